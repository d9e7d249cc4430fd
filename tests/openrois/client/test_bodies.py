"""A body is reserved whole or not at all, on every kind of gateway."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.client import BindingLost, Body, BodyLost, Client, ConnectionLost, Disconnected, ProfileChanged, where
from openrois.client.body_directory import Kind
from openrois.client.components import Move, Navigation, PersonDetection, Reaction, SpeechSynthesis
from openrois.engine.registry import LocalRegistry
from openrois.errors import BadParameter, OutOfResources, Unsupported
from tests.support.components import Lamp
from tests.support.fleet import Robot, everything
from tests.support.grounds import Clock, Ground, Line, eventually, heard

pytestmark = pytest.mark.extra(name="base")

NAVIGATIONS = ("robot/navigation", "second/navigation")


@pytest.fixture
async def second(ground: Ground) -> Robot:
    made = everything("second")
    await ground.engine.attach(made.registry)
    return made


async def test_all_components_are_of_one_body(second: Robot, client: Client, ground: Ground) -> None:
    async with ground.client() as other:
        async with client.body(Navigation, SpeechSynthesis, optional=Reaction) as body:
            assert body.engine_id == "robot"
            assert body[Navigation].component_ref == "robot/navigation"
            await body[SpeechSynthesis].set(speech_text="Hello!")
            await body[SpeechSynthesis].start()
            assert body.get(Reaction) is not None
            for ref in ("robot/navigation", "robot/speech_synthesizer", "robot/reaction"):
                with pytest.raises(OutOfResources):
                    await other.bind(ref)
        for ref in ("robot/navigation", "robot/speech_synthesizer", "robot/reaction"):
            await other.bind(ref)


async def test_the_next_body_is_taken_where_a_part_of_the_first_is(
    second: Robot, client: Client, ground: Ground
) -> None:
    async with ground.client() as other:
        await other.bind("robot/speech_synthesizer")
        async with client.body(Navigation, SpeechSynthesis, wait=0) as body:
            assert body.engine_id == "second"
            # Nothing of the other one is held.
            await other.bind("robot/navigation")


async def test_two_bodies_of_one_application_are_not_the_same(second: Robot, client: Client) -> None:
    async with client.body(Navigation) as one, client.body(Navigation) as two:
        assert {one.engine_id, two.engine_id} == {"robot", "second"}
        with pytest.raises(OutOfResources, match="a part of another body of this application"):
            async with client.body(Navigation, wait=0):
                pass


async def test_optional_parts_that_are_taken_do_not_fail_it(client: Client, ground: Ground) -> None:
    async with ground.client() as other:
        await other.bind("robot/reaction")
        async with client.body(Navigation, optional=[Reaction, Move, "Nothing"], wait=0) as body:
            assert body.get(Reaction) is None
            assert body[Move].component_ref == "robot/move"
            with pytest.raises(KeyError, match="robot is reserved without Reaction: there is Navigation, Move"):
                body[Reaction]


async def test_a_body_with_the_optional_parts_comes_first(client: Client, ground: Ground) -> None:
    await ground.engine.attach(LocalRegistry("alone", (Lamp("a"),)))
    await ground.engine.attach(LocalRegistry("both", (Lamp("b"), Lamp("c"))))
    lamp = "urn:x-rois:def:component:Test::Lamp"
    async with client.body(lamp, optional="urn:x-rois:def:component:Test::Bell") as body:
        assert body.engine_id == "toys"


async def test_of_several_components_of_a_type_the_first_is_taken_that_is_to_be_had(
    client: Client, ground: Ground
) -> None:
    await ground.engine.attach(LocalRegistry("arms", (Lamp("right"), Lamp("left"))))
    lamp, here = "urn:x-rois:def:component:Test::Lamp", "component_ref LIKE 'arms/%'"
    async with client.body(lamp, condition=here) as body:
        assert body[lamp].component_ref == "arms/left"
        await body[lamp].command("switch", times=1)
        async with ground.client() as other, other.body(lamp, condition=here) as another:
            assert another[lamp].component_ref == "arms/right"


async def test_a_condition_chooses_the_body(second: Robot, client: Client) -> None:
    async with client.body(Navigation, condition="component_ref LIKE 'second/%'") as body:
        assert body.engine_id == "second"
    async with client.body(Navigation, condition=where(component_ref="second/navigation")) as body:
        assert body.engine_id == "second"
    with pytest.raises(BadParameter):
        async with client.body(Navigation, condition="component_ref"):
            pass


async def test_what_needs_no_reservation_is_shared(client: Client, ground: Ground) -> None:
    async with ground.client() as other, other.body(PersonDetection) as one, client.body(PersonDetection) as two:
        assert one.engine_id == two.engine_id == "robot"


async def test_a_refusal_says_which_bodies_there_are_and_what_refused(
    second: Robot, client: Client, ground: Ground
) -> None:
    async with ground.client() as other:
        for ref in NAVIGATIONS:
            await other.bind(ref)
        with pytest.raises(OutOfResources) as refusal:
            async with client.body(Navigation, SpeechSynthesis, wait=0):
                pass
        said = str(refusal.value)
        assert said.startswith("no body with Navigation and SpeechSynthesis is free: robot: rois.command.bind(robot/n")
        assert "; second: rois.command.bind(second/navigation): OUT_OF_RESOURCES (" in said
        await other.bind("robot/speech_synthesizer")


async def test_without_such_a_body_it_says_which_there_are(client: Client) -> None:
    with pytest.raises(Unsupported) as refusal:
        async with client.body(Navigation, "Bell", wait=0):
            pass
    said = str(refusal.value)
    assert said.startswith("there is no body with Navigation and Bell; there are: robot (AudioStreaming, Face")
    assert said.endswith("toys (Bell, Lamp)")


@pytest.mark.parametrize(
    ("kinds", "options", "error", "said"),
    [
        ((), {}, ValueError, "name at least one component type"),
        ((Navigation, "Navigation"), {}, ValueError, "Navigation: named twice"),
        ((Navigation,), {"optional": (Move, Navigation)}, ValueError, "Navigation: named twice"),
        ((int,), {}, TypeError, "has no component_type"),
    ],
)
def test_a_wrong_request_is_refused_at_once(
    kinds: tuple[Any, ...], options: dict[str, Any], error: type[Exception], said: str
) -> None:
    with pytest.raises(error, match=said):
        Client().body(*kinds, **options)


async def test_bodies_are_listed_with_what_they_can_do_and_whether_they_are_free(
    second: Robot, client: Client, ground: Ground
) -> None:
    async with ground.client() as other, other.body(Navigation):
        robot, more, toys = await client.bodies()
    free = ground.extended or None
    assert [(each.component_ref, each.free) for each in toys.components] == [("toys/bell", free), ("toys/lamp", free)]
    assert robot.refs(Navigation) == ("robot/navigation",)
    assert (toys.free, robot.free, more.free) == (free, False if ground.extended else None, free)
    assert len(robot.components) == 17


# In time.


@pytest.fixture
async def waiting(line: Line, clock: Clock) -> AsyncIterator[Client]:
    async with Client(dial=line.dial, reconnect=clock.reconnect()) as connected:
        yield connected


@pytest.fixture
async def blocks() -> AsyncIterator[AsyncExitStack]:
    async with AsyncExitStack() as entered:
        yield entered


async def test_it_is_tried_again_until_the_wait_is_over(
    blocks: AsyncExitStack, line: Line, clock: Clock, waiting: Client
) -> None:
    async with Client(dial=line.dial) as other:
        await other.bind("robot/navigation")
        entering = enter(blocks, waiting, Navigation, wait=1.0)
        waits = []
        while clock.now < 1.0:
            waits.append(await clock.pass_time())
        with pytest.raises(OutOfResources, match="no body with Navigation is free: robot"):
            await entering
        assert waits == pytest.approx([0.1, 0.15, 0.225, 0.3375, 0.1875])


async def test_it_is_had_when_it_is_given_back_or_comes(
    blocks: AsyncExitStack, line: Line, clock: Clock, waiting: Client
) -> None:
    async with Client(dial=line.dial) as other:
        await other.bind("robot/navigation")
        entering = enter(blocks, waiting, Navigation)
        await clock.pass_time()
        await clock.asleep()
        await other.release("robot/navigation")
        await clock.pass_time()
        assert (await entering).engine_id == "robot"
        coming = enter(blocks, waiting, Navigation)
        await clock.asleep()
        changes = waiting.notices(ProfileChanged)
        await line.host.engine.attach(everything("second").registry)
        await heard(changes, ProfileChanged)
        await clock.pass_time()
        assert (await coming).engine_id == "second"


def enter(blocks: AsyncExitStack, client: Client, *kinds: Kind, wait: float = 10) -> asyncio.Task[Body]:
    """Begin to reserve a body, which is held until the blocks end."""
    return asyncio.ensure_future(blocks.enter_async_context(client.body(*kinds, wait=wait)))


async def test_of_two_at_the_same_moment_one_gets_it_at_once(blocks: AsyncExitStack, line: Line, clock: Clock) -> None:
    # Without chance and with opposite wishes: the order of binding alone keeps them from refusing each other for ever.
    async with (
        Client(dial=line.dial, reconnect=clock.reconnect()) as one,
        Client(dial=line.dial, reconnect=clock.reconnect()) as two,
    ):
        first = enter(blocks, one, Navigation, SpeechSynthesis)
        second = enter(blocks, two, SpeechSynthesis, Navigation)
        async with asyncio.timeout(60):
            had, waits = await asyncio.wait({first, second}, return_when=asyncio.FIRST_COMPLETED)
            await clock.asleep()
        assert (len(had), len(waits), clock.asked) == (1, 1, [0.1])
        waits.pop().cancel()


async def test_a_part_that_is_taken_by_an_administrator_ends_the_body(line: Line, waiting: Client) -> None:
    notices = waiting.notices(BindingLost, BodyLost)
    async with Client(dial=line.dial) as boss, waiting.body(Navigation, SpeechSynthesis) as body:
        assert body.error is None
        await boss.control.take("robot/speech_synthesizer")
        part, whole = await heard(notices, BindingLost, BodyLost)
        assert isinstance(part, BindingLost)
        assert whole == BodyLost("robot", "robot/speech_synthesizer", part.error)
        assert body.error is part.error
        assert body.get(Navigation) is None
        await eventually(boss, lambda: not held(line, "robot/navigation"))
        with pytest.raises(OutOfResources, match="bound first"):
            await body[Navigation].start()


async def test_an_optional_part_that_is_taken_is_lost_alone(line: Line, waiting: Client) -> None:
    notices = waiting.notices(BindingLost, BodyLost)
    async with Client(dial=line.dial) as boss, waiting.body(Navigation, optional=Reaction) as body:
        await boss.control.take("robot/reaction")
        await heard(notices, BindingLost)
        assert body.error is None
        assert body.get(Reaction) is None
        await body[Navigation].start()


async def test_an_engine_that_leaves_takes_the_body_along(line: Line, waiting: Client) -> None:
    notices = waiting.notices(ProfileChanged, BodyLost)
    lamp, bell = "urn:x-rois:def:component:Test::Lamp", "urn:x-rois:def:component:Test::Bell"
    async with waiting.body(lamp, bell) as body:
        line.host.engine.detach(line.toys)
        _, lost = await heard(notices, ProfileChanged, BodyLost)
        assert isinstance(lost, BodyLost)
        assert isinstance(body.error, Unsupported)
    await line.host.engine.attach(line.toys)
    async with waiting.body(lamp, bell), Client(dial=line.dial) as other:
        with pytest.raises(OutOfResources):
            await other.bind("toys/lamp")


async def test_a_body_survives_a_lost_connection(line: Line, clock: Clock, waiting: Client) -> None:
    notices = waiting.notices(Disconnected, BodyLost)
    async with waiting.body(Navigation, SpeechSynthesis) as body:
        line.cut()
        await heard(notices, Disconnected)
        await clock.pass_time()
        await waiting.search()
        assert body.error is None
        await body[Navigation].start()


async def test_a_body_of_which_another_application_has_a_part_by_then_is_given_back(
    line: Line, clock: Clock, waiting: Client
) -> None:
    notices = waiting.notices(Disconnected, BodyLost)
    async with waiting.body(Navigation, SpeechSynthesis) as body:
        line.cut()
        await heard(notices, Disconnected)
        async with Client(dial=line.dial) as other:
            await other.bind("robot/navigation")
            await clock.pass_time()
            await heard(notices, BodyLost)
            assert body.error is not None
            await eventually(other, lambda: not held(line, "robot/speech_synthesizer"))


async def test_a_client_that_is_closed_has_no_body(line: Line, waiting: Client) -> None:
    async with waiting.body(Navigation) as body:
        await waiting.close()
        assert isinstance(body.error, ConnectionLost)


async def test_cancelling_releases_what_was_bound_at_any_moment(line: Line) -> None:
    async def hold(client: Client) -> None:
        async with client.body(Navigation, SpeechSynthesis, Move):
            await asyncio.Event().wait()

    moments = set()
    async with Client(dial=line.dial) as client:
        for turns in range(60):
            holding = asyncio.ensure_future(hold(client))
            for _ in range(turns):
                await asyncio.sleep(0)
            moments.add(len(held(line)))
            holding.cancel()
            await asyncio.wait({holding})
            # An answer that comes after that is one more question's time away from the release.
            for _ in range(2):
                await client.search()
            assert not held(line), turns
    assert moments == {0, 1, 2, 3}


def held(line: Line, *refs: str) -> set[str]:
    """Return which components are held at the gateway, of some or of all."""
    found = set(line.host.leases.model.holding.held())
    return found & set(refs) if refs else found
