"""Component proxies: the basic ones with every message of the catalog, and those of types that are in none."""

import asyncio
from typing import Annotated, Any

import pytest

from openrois.catalog.actuation import NavigationParameters
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import CommandType, ComponentType, EventType, QueryType
from openrois.catalog.payload import Data, Payload
from openrois.client import Client, ComponentProxy, ProfileChanged, Step, components, where
from openrois.client.components import (
    Follow,
    Navigation,
    PersonDetection,
    RoISCommon,
    SpeechSynthesis,
    SystemInformation,
)
from openrois.component.authoring.marks import command
from openrois.component.component import Component
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed, OutOfResources, Unsupported
from openrois.types.codes import ComponentStatus
from tests.support.fleet import NOON, everything, example
from tests.support.grounds import Ground

pytestmark = pytest.mark.extra(name="base")

STREAMS = ("AudioStreaming", "VideoStreaming")


def proxy_class(kind: ComponentType) -> type[ComponentProxy]:
    found: type[ComponentProxy] = getattr(components, kind.code)
    return found


@pytest.mark.parametrize("kind", BASIC_COMPONENTS, ids=lambda kind: str(kind.code))
class TestBasicComponents:
    async def test_is_found_by_its_type(self, client: Client, kind: ComponentType) -> None:
        proxy = await client.find(proxy_class(kind))
        assert type(proxy) is proxy_class(kind)
        assert proxy.component_ref == f"robot/{kind.name}"
        assert (await proxy.profile()).component_type == kind.urn

    async def test_every_query_is_answered(self, client: Client, kind: ComponentType) -> None:
        proxy = await client.find(proxy_class(kind))
        for query in kind.all_queries():
            if query.name == "component_status":
                assert await getattr(proxy, query.name)() is ComponentStatus.READY
            elif kind.code not in STREAMS:
                answer, expected = await getattr(proxy, query.name)(), example(query.results)
                fields = list(query.results.model_fields)
                assert answer == (expected if len(fields) > 1 else getattr(expected, fields[0]))

    async def test_every_event_is_heard(self, ground: Ground, client: Client, kind: ComponentType) -> None:
        proxy = await client.find(proxy_class(kind))
        for event in kind.all_events():
            async with getattr(proxy, event.name)() as heard:
                assert ground.robot.parts[kind.code].tell(event.name) == await anext(heard)

    async def test_every_parameter_is_set_and_read(self, client: Client, kind: ComponentType) -> None:
        data = {} if kind.parameters is None else kind.parameters.data()
        settable = {name for name, said in data.items() if not said.read_only}
        assert hasattr(proxy_class(kind), "set") == bool(settable)
        if kind.parameters is None:
            return
        proxy: Any = await client.find(proxy_class(kind))
        chosen = example(kind.parameters).model_dump(include=settable)
        if settable:
            async with proxy.bound():
                await proxy.set(**chosen)
        assert (await proxy.parameters()).model_dump(include=settable) == chosen

    async def test_the_common_commands_run(self, ground: Ground, client: Client, kind: ComponentType) -> None:
        if ROIS_COMMON not in kind.includes:
            assert not hasattr(proxy_class(kind), "start")
            return
        proxy: Any = await client.find(proxy_class(kind))
        async with proxy.bound():
            for command in ("stop", "suspend", "resume"):
                await getattr(proxy, command)()
            if kind.code != "Follow":
                await proxy.start()
        assert {"stop", "suspend", "resume"} <= set(ground.robot.parts[kind.code].done)


async def test_navigation_as_the_guide_shows_it(ground: Ground, client: Client) -> None:
    navigation = client.component(Navigation, "robot/navigation")
    async with navigation.bound(), navigation.reached_target() as targets:
        await client.run(navigation.set(target_positions=["hall", "lobby"], time_limit=1000), navigation.start())
        assert [(each.target, each.is_final_target) for each in [await anext(targets), await anext(targets)]] == [
            ("hall", False),
            ("lobby", True),
        ]
    assert await navigation.parameters() == NavigationParameters(target_positions=("hall", "lobby"), time_limit=1000)
    with pytest.raises(OutOfResources):
        await navigation.start()


async def test_what_is_not_named_stays_as_it_is(client: Client) -> None:
    speech = await client.find(SpeechSynthesis)
    async with speech.bound():
        await speech.set(speech_text="hello", volume=80)
        await speech.set(volume=None, language="ja")
    parameters = await speech.parameters()
    assert (parameters.speech_text, parameters.volume, parameters.language) == ("hello", 80, "ja")


async def test_a_text_is_no_list_of_texts(client: Client) -> None:
    navigation = await client.find(Navigation)
    async with navigation.bound():
        with pytest.raises(BadParameter, match=r"target_positions: .* is a JSON array"):
            await navigation.set(target_positions="lobby")  # type: ignore[arg-type]


async def test_following_goes_on_until_it_is_stopped(ground: Ground, client: Client) -> None:
    follow = await client.find(Follow)
    async with follow.bound():
        following = await follow.start().execute()
        await ground.robot.parts["Follow"].following.wait()
        await follow.stop()
        with pytest.raises(Aborted):
            await following


async def test_a_component_that_does_not_work_says_so(ground: Ground, client: Client) -> None:
    ground.robot.parts["SystemInformation"].is_in = ComponentStatus.ERROR
    with pytest.raises(
        ComponentFailed, match=r"the component is not connected yet, or does not work|does not work now"
    ):
        await (await client.find(SystemInformation)).robot_position()


async def test_of_several_the_condition_says_which(ground: Ground, client: Client) -> None:
    await ground.engine.attach(everything("second").registry)
    with pytest.raises(BadParameter) as refusal:
        await client.find(Navigation)
    assert str(refusal.value) == (
        "there are 2 components Navigation: robot/navigation, second/navigation; take one that is free by"
        ' `client.body(Navigation)`, or name one: `where(component_ref="robot/navigation")`'
    )
    assert (await client.find(Navigation, "component_ref LIKE 'second/%'")).component_ref == "second/navigation"
    assert [each.component_ref for each in await client.find_all(Navigation)] == [
        "robot/navigation",
        "second/navigation",
    ]
    with pytest.raises(Unsupported, match="there is no Navigation where component_ref = 'third/navigation'"):
        await client.find(Navigation, where(component_ref="third/navigation"))


async def test_a_component_may_be_waited_for(ground: Ground, client: Client) -> None:
    ground.engine.detach(ground.robot.registry)
    finding = asyncio.ensure_future(client.find(Navigation, within=5))
    with pytest.raises(Unsupported, match="there is no Navigation"):
        await client.find(Navigation)
    await ground.engine.attach(everything("late").registry)
    assert (await finding).component_ref == "late/navigation"
    with pytest.raises(Unsupported, match="there is no Navigation where component_ref = 'x'"):
        await client.find(Navigation, where(component_ref="x"), within=0.01)


async def test_of_blocks_inside_each_other_the_last_gives_the_component_back(ground: Ground, client: Client) -> None:
    navigation = await client.find(Navigation)
    async with ground.client() as other:
        async with navigation.bound():
            async with navigation.bound():
                pass
            with pytest.raises(OutOfResources):
                await other.bind(navigation.component_ref)
        await other.bind(navigation.component_ref)


async def test_blocks_of_several_tasks_do_not_give_away_what_another_has(client: Client) -> None:
    lamp = client.component(LAMP, "toys/lamp")

    async def switch() -> None:
        for _ in range(20):
            async with lamp.bound():
                await lamp.command("switch", times=1)

    await asyncio.gather(*(switch() for _ in range(5)))


async def test_a_block_does_not_give_back_what_was_bound_for_good(ground: Ground, client: Client) -> None:
    lamp = client.component(LAMP, "toys/lamp")
    await lamp.bind()
    async with lamp.bound():
        pass
    await lamp.command("switch", times=1)
    await lamp.release()
    async with ground.client() as other:
        await other.bind("toys/lamp")


async def test_a_component_may_be_given_back_inside_the_block(ground: Ground, client: Client) -> None:
    navigation = await client.find(Navigation)
    async with ground.client() as other, navigation.bound():
        await navigation.release()
        await other.bind(navigation.component_ref)
    with pytest.raises(OutOfResources):
        await navigation.start()


async def test_a_component_that_is_gone_when_the_block_ends_is_no_error(ground: Ground, client: Client) -> None:
    navigation = await client.find(Navigation)
    async with navigation.bound():
        ground.engine.detach(ground.robot.registry)
    with pytest.raises(Unsupported):
        await navigation.bind()


class Switched(Payload):
    """The lamp was switched."""

    total: int


class SwitchArguments(Payload):
    """How to switch it."""

    times: Annotated[int, Data(description="how often")]
    note: str | None = None


class Brightness(Payload):
    """How bright it is."""

    level: int


class LampParameters(Payload):
    """How it shines."""

    colour: str = "white"
    level: int = 5


LAMP = ComponentType(
    code="Lamp",
    name="lamp",
    description="A lamp.",
    source="the test",
    authority="Test",
    commands=(CommandType("switch", "Switch it.", SwitchArguments, Switched), CommandType("start", "Glow.")),
    queries=(QueryType("brightness", "Ask how bright it is.", Brightness),),
    events=(EventType("switched", "It was switched.", Switched),),
    parameters=LampParameters,
)


class Lamp(ComponentProxy):
    """A proxy as an application writes one."""

    component_type = LAMP

    def switch(self, times: int) -> Step[Switched]:
        return self.command("switch", Switched, times=times)


async def test_a_proxy_of_ones_own(client: Client) -> None:
    lamp = await client.find(Lamp)
    async with lamp.bound(), lamp.event("switched", Switched) as switched:
        assert (await lamp.switch(times=3)).total == 3
        assert await anext(switched) == Switched(total=3)
    assert (await lamp.query("brightness", Brightness)).level == 5
    assert await lamp.get_parameter(LampParameters) == LampParameters()
    assert repr(lamp) == "<Lamp toys/lamp>"


async def test_a_component_type_is_enough(ground: Ground, client: Client) -> None:
    lamp = await client.find(LAMP)
    async with lamp.bound():
        assert await lamp.command("switch", times=3) == {"total": 3}
        with pytest.raises(BadParameter, match="takes no often; there are: times, note"):
            await lamp.command("switch", often=3)
    assert client.component(LAMP, "toys/lamp").component_ref == lamp.component_ref


async def test_a_component_whose_type_is_not_known_is_read_from_its_profile(ground: Ground, client: Client) -> None:
    lamp = client.component("toys/lamp")
    async with lamp.bound(), lamp.event("switched") as switched:
        assert await lamp.command("switch", times=2, note="twice") == {"total": 2}
        assert await anext(switched) == {"total": 2}
        await lamp.set_parameter(level=9, colour="red")
        assert await lamp.get_parameter() == {"level": 9, "colour": "red"}
    assert await lamp.query("brightness") == {"level": 9}
    with pytest.raises(Unsupported, match="there is no component toys/nothing"):
        await client.component("toys/nothing").command("switch")


async def test_a_component_that_comes_back_as_another_is_read_again(ground: Ground, client: Client) -> None:
    changed = client.notices(ProfileChanged)
    await ground.engine.attach(shelf := LocalRegistry("shelf", (Toy("thing"),)))
    thing = client.component("shelf/thing")
    assert await thing.command("squeak", times=2) == {}
    ground.engine.detach(shelf)
    await ground.engine.attach(LocalRegistry("shelf", (OtherToy("thing"),)))
    for _ in range(3):
        await anext(changed)
    assert await thing.command("squeak", loudly=True) == {}


class Toy(Component, authority="Test"):
    """Squeaks so many times."""

    @command
    async def squeak(self, times: int) -> None:
        assert times


class OtherToy(Component, authority="Test"):
    """Squeaks in another way."""

    @command
    async def squeak(self, loudly: bool) -> None:
        assert loudly


async def test_what_gives_what_does_not_fit_is_named(client: Client) -> None:
    class Wrong(Payload):
        colour: int

    with pytest.raises(
        ComponentFailed, match="brightness of toys/lamp returned a value that does not fit: colour: Field required"
    ):
        await client.component("toys/lamp").query("brightness", Wrong)


async def test_only_what_has_a_type_can_be_looked_for(client: Client) -> None:
    with pytest.raises(TypeError, match="no component_type"):
        await client.find(ComponentProxy)
    assert (await client.find_all(RoISCommon)) == []


async def test_the_number_of_persons(ground: Ground, client: Client) -> None:
    persons = await client.find(PersonDetection)
    async with persons.person_detected() as detected:
        await persons.start()
        person = await anext(detected)
        assert (person.number, person.timestamp) == (1, NOON)
