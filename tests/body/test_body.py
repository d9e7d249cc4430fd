"""Commands to the game engine and the end of what it was asked to do."""

import asyncio
import logging

import pytest
from openrois_body.body import Body
from openrois_body.messages import (
    Command,
    Completed,
    LinkError,
    Log,
    Look,
    React,
    Silence,
    Speak,
    Status,
    Stop,
    Viewpoint,
)

from openrois.errors import Aborted, ComponentFailed


class Engine:
    """Keeps the commands it receives; can be gone."""

    def __init__(self) -> None:
        self.told: list[Command] = []
        self.gone = False

    def send(self, command: Command) -> None:
        if self.gone:
            raise LinkError("the engine is gone")
        self.told.append(command)


@pytest.fixture
def engine() -> Engine:
    return Engine()


@pytest.fixture
def body(engine: Engine) -> Body:
    return Body(engine.send)


async def started(body: Body, engine: Engine) -> tuple["asyncio.Future[None]", str]:
    reacting = asyncio.ensure_future(body.react("nod"))
    await asyncio.sleep(0)
    told = engine.told[-1]
    assert isinstance(told, React)
    assert told.reaction == "nod"
    return reacting, told.id


@pytest.mark.parametrize(("status", "error"), [("OK", None), ("ABORT", Aborted), ("ERROR", ComponentFailed)])
async def test_a_reaction_ends_as_the_engine_says(
    body: Body, engine: Engine, status: Status, error: type[Exception] | None
) -> None:
    reacting, reaction_id = await started(body, engine)
    body.handle_event(Completed("another id", "ERROR"))
    assert not reacting.done()
    body.handle_event(Completed(reaction_id, status))
    body.handle_event(Completed(reaction_id, "OK"))
    if error is None:
        await reacting
    else:
        with pytest.raises(error):
            await reacting


async def test_cancelling_a_reaction_stops_the_avatar(body: Body, engine: Engine) -> None:
    reacting, reaction_id = await started(body, engine)
    reacting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await reacting
    assert engine.told[-1] == Stop(reaction_id)


async def test_a_lost_engine_fails_what_it_was_doing(body: Body, engine: Engine) -> None:
    reacting, _ = await started(body, engine)
    body.engine_lost()
    with pytest.raises(ComponentFailed, match="disconnected"):
        await reacting


async def test_without_an_engine_a_reaction_fails_and_speech_goes_on_without_a_mouth(
    body: Body, engine: Engine
) -> None:
    engine.gone = True
    with pytest.raises(ComponentFailed, match="gone"):
        await body.react("nod")
    with pytest.raises(ComponentFailed, match="gone"):
        body.turn_eyes(0.0, 0.0)
    body.speak("s", [Speak("s", 0, (), 0)])
    body.silence()


def test_speech_silence_and_looks_are_passed_on(body: Body, engine: Engine) -> None:
    body.speak("s", [Speak("s", 17, (), 250)])
    body.silence()
    body.turn_eyes(0.5, -0.25)
    assert engine.told == [Speak("s", 17, (), 250), Silence(), Look(0.5, -0.25)]


def test_an_engine_that_is_there_again_is_told_what_is_being_said(body: Body, engine: Engine) -> None:
    said = [Speak("a", 17, (), 250), Speak("a", 267, (), 250)]
    body.speak("a", said)
    body.speak("b", [Speak("b", 900, (), 250)])
    body.spoken("b")
    engine.told.clear()
    body.engine_returned(())
    assert engine.told == said
    body.silence()
    body.engine_returned(())
    assert engine.told == [*said, Silence()]


def test_an_engine_that_comes_later_shows_the_figure_from_where_the_one_before_did(body: Body, engine: Engine) -> None:
    body.engine_returned(("automatic", "face"))
    body.show_from("face")
    body.engine_returned(("automatic", "face"))
    assert engine.told == [Viewpoint("face"), Viewpoint("face")]
    engine.gone = True
    with pytest.raises(ComponentFailed, match="gone"):
        body.show_from("room")
    assert body.viewpoint == "face"


def test_an_engine_that_comes_later_is_told_of_no_viewpoint_that_it_does_not_have(body: Body, engine: Engine) -> None:
    body.show_from("face")
    engine.told.clear()
    body.engine_returned(())  # an engine that has none does not know the command, and ends its link
    body.engine_returned(("automatic", "room"))
    assert engine.told == []
    body.engine_returned(("automatic", "face"))
    assert engine.told == [Viewpoint("face")]


def test_a_flood_of_lines_is_cut_and_no_line_is_several(engine: Engine, caplog: pytest.LogCaptureFixture) -> None:
    body = Body(engine.send, lambda: 5.0)
    with caplog.at_level(logging.INFO, "openrois_body.body"):
        body.handle_event(Log("one\ntwo"))
        for _ in range(100):
            body.handle_event(Log("more"))
    assert caplog.messages[0] == "game engine: one / two"
    assert caplog.messages.count("game engine: more") == 19
    assert caplog.messages[-1] == "lines of the game engine that are not logged: 64 so far"
