"""The avatar's components as an engine sees them: profiles, queries, parameters and commands."""

import asyncio
import json

import pytest
from openrois_avatar.components.viewpoint import Viewpoint
from openrois_body.body import Body
from openrois_body.components.gaze import Gaze
from openrois_body.components.reaction import Reaction, reaction_ref
from openrois_body.components.system_information import SystemInformation
from openrois_body.messages import Command, Completed, Look, Place, React, Stop
from openrois_body.messages import Viewpoint as LinkViewpoint

from openrois.contract import Event, SubscriptionLost
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed, Unsupported
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument, Result


class Stage:
    """The components over a game engine whose status and answers the test decides."""

    def __init__(self) -> None:
        self.status = ComponentStatus.READY
        self.place: Place | None = None
        self.viewpoints: tuple[str, ...] = ("automatic", "face")
        self.wall = 1_700_000_000.25
        self.told: list[Command] = []
        self.reacting: asyncio.Queue[React] = asyncio.Queue()
        self.body = Body(self._tell)
        self.registry = LocalRegistry(
            "avatar",
            [
                SystemInformation("avatar", lambda: self.status, lambda: self.place, lambda: self.wall),
                Reaction(self.body, lambda: ("nod", "wave"), lambda: self.status),
                Gaze(self.body, lambda: self.status),
                Viewpoint(self.body, lambda: self.viewpoints, lambda: self.status),
            ],
        )

    def _tell(self, command: Command) -> None:
        self.told.append(command)
        if isinstance(command, React):
            self.reacting.put_nowait(command)

    async def set(self, component: str, **values: str) -> None:
        arguments = tuple(Argument(name=name, data_type_ref="string", value=value) for name, value in values.items())
        await self.registry.invoke(f"avatar/{component}", "set_parameter", arguments)

    async def react(self) -> tuple["asyncio.Future[tuple[Result, ...]]", str]:
        running = asyncio.ensure_future(self.registry.invoke("avatar/reaction", "start"))
        async with asyncio.timeout(60):
            told = await self.reacting.get()
        return running, told.id


@pytest.fixture
def stage() -> Stage:
    return Stage()


async def values(stage: Stage, component: str, query: str) -> dict[str, str]:
    return {result.name: result.value for result in await stage.registry.query(f"avatar/{component}", query)}


async def test_system_information_tells_place_time_and_engine_status(stage: Stage) -> None:
    assert await values(stage, "system_info", "robot_position") == {
        "timestamp": "2023-11-14T22:13:20.250000+00:00",
        "robot_ref": '["avatar"]',
        "position_data": '["0.000,0.000,-1.5708"]',
    }
    stage.place = Place(1.25, -2.5, 0.5)
    assert (await values(stage, "system_info", "robot_position"))["position_data"] == '["1.250,-2.500,0.5000"]'
    stage.status = ComponentStatus.ERROR
    stage.wall += 60
    assert await values(stage, "system_info", "engine_status") == {
        "status": "ERROR",
        "operable_time": "2023-11-14T22:13:20.250000+00:00",
    }
    assert (await values(stage, "system_info", "robot_position"))["timestamp"] == "2023-11-14T22:14:20.250000+00:00"


async def test_system_information_has_no_rois_common(stage: Stage) -> None:
    with pytest.raises(Unsupported):
        await stage.registry.query("avatar/system_info", "component_status")


async def test_reactions_are_named_by_annex_d_or_by_our_own_book(stage: Stage) -> None:
    refs = json.loads((await values(stage, "reaction", "available_reactions"))["available_reactions"])
    assert refs == ["urn:x-rois:def:reaction:OMG::1", "urn:x-rois:def:reaction:OpenRoIS::wave"]


@pytest.mark.parametrize(
    ("name", "number"),
    [("nod", 1), ("tilt", 2), ("shake_head", 3), ("bow", 9), ("shake_hands", 10), ("glance_at_watch", 50)],
)
def test_a_reaction_of_annex_d_has_its_number(name: str, number: int) -> None:
    assert reaction_ref(name) == f"urn:x-rois:def:reaction:OMG::{number}"


async def test_a_reaction_plays_and_completes(stage: Stage) -> None:
    await stage.set("reaction", reaction_ref=reaction_ref("nod"))
    running, reaction_id = await stage.react()
    assert await values(stage, "reaction", "component_status") == {"status": "BUSY"}
    stage.body.handle_event(Completed(reaction_id, "OK"))
    assert await running == ()


async def test_stop_ends_a_reaction_with_abort(stage: Stage) -> None:
    await stage.set("reaction", reaction_ref=reaction_ref("wave"))
    running, reaction_id = await stage.react()
    await stage.registry.invoke("avatar/reaction", "stop")
    with pytest.raises(Aborted):
        await running
    assert stage.told[-1] == Stop(reaction_id)


async def test_a_reaction_that_never_ends_cannot_block_the_rest(stage: Stage) -> None:
    profile = (await stage.registry.discover()).component_profiles["avatar/reaction"]
    start = profile.command("start")
    assert start is not None
    assert start.timeout == 30_000


async def test_an_unknown_reaction_is_refused_and_nothing_is_stored(stage: Stage) -> None:
    with pytest.raises(BadParameter, match="no reaction"):
        await stage.set("reaction", reaction_ref="urn:x-rois:def:reaction:OMG::49")
    with pytest.raises(BadParameter, match="reaction_ref is not set"):
        await stage.registry.invoke("avatar/reaction", "start")


async def test_without_a_game_engine_the_component_says_so(stage: Stage) -> None:
    stage.status = ComponentStatus.ERROR
    assert await values(stage, "reaction", "component_status") == {"status": "ERROR"}
    with pytest.raises(ComponentFailed):
        await stage.registry.query("avatar/reaction", "available_reactions")


async def test_gaze_looks_where_it_is_told(stage: Stage) -> None:
    arguments = (
        Argument(name="x", data_type_ref="double", value="-0.5"),
        Argument(name="y", data_type_ref="double", value="0.25"),
    )
    await stage.registry.invoke("avatar/gaze", "look", arguments)
    assert stage.told == [Look(-0.5, 0.25)]


@pytest.mark.parametrize("x", ["1.5", "left", "nan"])
async def test_gaze_refuses_what_is_no_direction(stage: Stage, x: str) -> None:
    with pytest.raises(BadParameter):
        await stage.registry.invoke("avatar/gaze", "look", (Argument(name="x", data_type_ref="double", value=x),))
    assert stage.told == []


async def choose(stage: Stage, viewpoint: str) -> None:
    argument = Argument(name="viewpoint", data_type_ref="string", value=viewpoint)
    await stage.registry.invoke("avatar/viewpoint", "choose", (argument,))


async def test_all_viewers_see_it_from_the_viewpoint_that_was_chosen(stage: Stage) -> None:
    told: list[str] = []

    def hear(event: Event | SubscriptionLost) -> None:
        assert isinstance(event, Event)
        told.append(event.results[0].value)

    subscription = await stage.registry.subscribe("avatar/viewpoint", "viewpoint_changed", hear)
    assert await values(stage, "viewpoint", "viewpoint") == {"viewpoint": "automatic"}
    for viewpoint in ("face", "face", "automatic"):
        await choose(stage, viewpoint)
        assert await values(stage, "viewpoint", "viewpoint") == {"viewpoint": viewpoint}
    assert [command.name for command in stage.told if isinstance(command, LinkViewpoint)] == ["face", "automatic"]
    assert told == ["face", "automatic"]
    await stage.registry.unsubscribe(subscription)


async def test_a_viewpoint_that_the_engine_does_not_have_is_refused(stage: Stage) -> None:
    with pytest.raises(BadParameter, match="no viewpoint 'moon'; available_viewpoints: automatic, face"):
        await choose(stage, "moon")
    assert stage.told == []


async def test_an_engine_without_viewpoints_supports_no_choice_of_them(stage: Stage) -> None:
    stage.viewpoints = ()
    assert await values(stage, "viewpoint", "component_status") == {"status": "READY"}
    assert await values(stage, "viewpoint", "viewpoint") == {"viewpoint": ""}
    with pytest.raises(Unsupported, match="the game engine offers no viewpoints"):
        await choose(stage, "face")
    assert stage.told == []
