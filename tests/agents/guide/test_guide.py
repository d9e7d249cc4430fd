"""The guide of `docs/examples`: a visit, and whatever may go wrong in one; a second application sees what is told."""

import asyncio
import signal
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from openrois.client import Client, ComponentProxy, ConnectionLost, ControlRequested, OutOfResources
from openrois.client.components import Navigation
from tests.support.conversing import until
from tests.support.guided import AVATAR_VOICE, LEGS, ROBOT_VOICE, House, example, guide, guide_process, house, token

FAR = -4.0, -2.5
"""From where the robot takes some seconds to the plant."""


async def begin_walk(opened: House) -> None:
    """Come as a visitor, and be led until the robot moves."""
    await opened.hears()
    opened.say("take me to the plant please")
    await opened.tells("Hello!")
    await opened.tells("Please follow the robot to the plant.")
    await opened.moves()


async def test_a_visitor_is_greeted_led_and_taken_leave_of_and_nothing_stays_held(tmp_path: Path) -> None:
    async with house(tmp_path) as opened, guide(opened, tmp_path):
        await opened.hears()
        opened.say("good morning")
        await opened.tells("Hello!", by="avatar")
        await opened.tells("I can lead you to: ")
        opened.say("take me to the plant please")
        await opened.tells("Please follow the robot to the plant.")
        await opened.tells("Here we are: the plant.")
        await opened.is_free(LEGS)
        opened.say("goodbye")
        await opened.tells("Goodbye!", by="avatar")
        await opened.is_free(AVATAR_VOICE)


async def test_stop_is_heard_on_the_way(tmp_path: Path) -> None:
    async with house(tmp_path, *FAR) as opened, guide(opened, tmp_path):
        await begin_walk(opened)
        opened.say("stop")
        await opened.tells("I stop.")
        await opened.stands()
        await opened.is_free(LEGS)


@pytest.mark.long
async def test_stop_waits_for_no_sentence(tmp_path: Path) -> None:
    async with house(tmp_path, *FAR) as opened, guide(opened, tmp_path):
        await begin_walk(opened)
        opened.synthesizer.seconds = 30.0
        opened.say("what can you do")
        await opened.tells("I can lead you to: ")
        opened.say("stop")
        await opened.stands()
        await opened.is_free(LEGS)


async def test_the_robot_speaks_where_another_application_has_the_avatar(tmp_path: Path) -> None:
    async with house(tmp_path) as opened, Client(opened.url, token=token("ann", rank="person")) as ann:
        await ann.bind(AVATAR_VOICE)
        async with guide(opened, tmp_path):
            await opened.hears()
            opened.say("take me to the plant")
            await opened.tells("Hello!", by="robot")
            await opened.tells("Here we are: the plant.", by="robot")
            opened.say("goodbye")
            await opened.tells("Goodbye!", by="robot")
            await opened.is_free(ROBOT_VOICE)


async def test_a_visitor_is_told_that_another_application_has_the_robot(tmp_path: Path) -> None:
    async with house(tmp_path) as opened, Client(opened.url, token=token("ann", rank="person")) as ann:
        await ann.bind(LEGS)
        here = opened.place
        async with guide(opened, tmp_path):
            await opened.hears()
            opened.say("take me to the plant")
            await opened.tells("The robot is not free now. Ask me again later.", by="avatar")
            assert opened.place == here
            await ann.release(LEGS)
            opened.say("take me to the plant")
            await opened.tells("Here we are: the plant.", by="avatar")


@pytest.mark.long
async def test_the_avatar_goes_on_where_the_robot_is_lost_on_the_way(tmp_path: Path) -> None:
    async with house(tmp_path, *FAR) as opened, guide(opened, tmp_path):
        await begin_walk(opened)
        opened.robots.cut(refuse=True)
        await opened.tells("The robot cannot go on. Please wait there; I am here for you.", by="avatar")
        opened.say("what now")
        await opened.tells("I can lead you to: ", by="avatar")
        here = opened.place
        opened.say("goodbye")
        await opened.tells("Goodbye!", by="avatar")
        assert opened.place == here
        await opened.is_free(AVATAR_VOICE)


async def test_the_avatar_goes_on_where_the_robot_is_killed_on_the_way(tmp_path: Path) -> None:
    async with house(tmp_path, robot_process=True) as opened, guide(opened, tmp_path):
        await opened.hears()
        opened.say("take me to the plant")
        await opened.tells("Please follow the robot to the plant.", by="avatar")
        await opened.is_busy(LEGS)
        assert opened.robot_process is not None
        opened.robot_process.signal(signal.SIGKILL)
        await opened.tells("The robot cannot go on. Please wait there; I am here for you.", by="avatar")
        opened.say("take me to the plant")
        await opened.tells("The robot is not free now. Ask me again later.", by="avatar")
        opened.say("goodbye")
        await opened.tells("Goodbye!", by="avatar")
        await opened.is_free(AVATAR_VOICE)


@pytest.mark.long
async def test_the_robot_goes_on_where_the_avatar_is_lost(tmp_path: Path) -> None:
    async with house(tmp_path) as opened, guide(opened, tmp_path):
        await opened.hears()
        opened.say("hello")
        await opened.tells("I can lead you to: ", by="avatar")
        opened.avatars.cut(refuse=True)
        await opened.tells("I had to leave the avatar, and go on here.", by="robot")


async def test_a_person_stops_the_robot_and_it_stays_stopped(tmp_path: Path) -> None:
    async with (
        house(tmp_path, *FAR) as opened,
        Client(opened.url, token=token("ann", rank="person")) as ann,
        guide(opened, tmp_path),
    ):
        await begin_walk(opened)
        await ann.control.stop_all("robot")
        await opened.tells("The robot cannot go on. Please wait there; I am here for you.", by="avatar")
        await opened.stands()
        await opened.is_free(LEGS)


async def test_a_person_borrows_the_robot_and_the_way_goes_on_behind_that(tmp_path: Path) -> None:
    async with (
        house(tmp_path) as opened,
        Client(opened.url, token=token("ann", rank="person")) as ann,
        guide(opened, tmp_path),
    ):
        await begin_walk(opened)
        await ann.control.borrow(LEGS, seconds=30)
        await opened.tells("ann has the robot for 30 seconds. I wait until it is back.")
        await opened.stands()
        await ann.control.give_back(LEGS)
        await opened.tells("We go on to the plant.")
        await opened.tells("Here we are: the plant.")
        await opened.is_free(LEGS)


@pytest.mark.long
async def test_an_application_requests_the_robot_and_gives_it_back(tmp_path: Path) -> None:
    # Of the same rank, it cannot borrow it.
    async with (
        house(tmp_path) as opened,
        Client(opened.url, token=token("bob", rank="agent")) as bob,
        guide(opened, tmp_path),
    ):
        await begin_walk(opened)
        async with bob.notices(ControlRequested) as requests:
            await bob.control.request(LEGS)
            await opened.tells("bob may have the robot. I wait until it is back.")
            await opened.stands()
            assert (await anext(requests)).subject == "guide"
        await bob.release(LEGS)
        await opened.tells("We go on to the plant.")
        await opened.tells("Here we are: the plant.")


@pytest.mark.long
async def test_a_person_borrows_the_voice_in_mid_sentence_and_it_is_said_again(tmp_path: Path) -> None:
    async with (
        house(tmp_path) as opened,
        Client(opened.url, token=token("ann", rank="person")) as ann,
        guide(opened, tmp_path),
    ):
        await opened.hears()
        opened.synthesizer.seconds = 5.0
        opened.say("hello")
        await opened.tells("Hello!", by="avatar")
        opened.synthesizer.seconds = 0.2
        await ann.control.borrow(AVATAR_VOICE, seconds=30)
        await ann.control.give_back(AVATAR_VOICE)
        await opened.tells("Hello!", by="avatar")
        await opened.tells("I can lead you to: ", by="avatar")


async def test_killed_in_mid_sentence_the_next_process_tells_it(tmp_path: Path) -> None:
    async with house(tmp_path, *FAR) as opened:
        async with guide_process(opened, tmp_path) as first:
            await begin_walk(opened)
            opened.synthesizer.seconds = 2.0
            opened.say("what can you do")
            await opened.tells("I can lead you to: ")
            first.signal(signal.SIGKILL)
            await first.ended()
            await opened.stands()
        await asyncio.gather(opened.is_free(LEGS), opened.is_free(AVATAR_VOICE))
        opened.synthesizer.seconds = 0.2
        async with guide_process(opened, tmp_path):
            await opened.tells("I am sorry, I was interrupted.")
            opened.say("goodbye")
            await opened.tells("Goodbye!")


@pytest.mark.long
async def test_where_the_network_is_cut_the_robot_stops_and_the_way_goes_on_when_it_is_back(tmp_path: Path) -> None:
    async with house(tmp_path) as opened, guide(opened, tmp_path):
        await begin_walk(opened)
        opened.guides.cut()
        await opened.tells("I was cut off for a moment. I am here again.")
        await opened.tells("We go on to the plant.")
        await opened.tells("Here we are: the plant.")


async def test_where_the_network_is_cut_for_long_nothing_moves_or_stays_held_and_then_it_goes_on(
    tmp_path: Path,
) -> None:
    async with house(tmp_path, *FAR) as opened, guide(opened, tmp_path):
        await begin_walk(opened)
        opened.guides.cut(refuse=True)
        await opened.stands()
        await asyncio.gather(opened.is_free(LEGS), opened.is_free(AVATAR_VOICE))
        opened.guides.mend()
        await opened.tells("I was cut off for a moment. I am here again.")
        await opened.tells("We go on to the plant.")


@pytest.mark.long
async def test_a_gateway_that_is_lost_while_the_robot_is_looked_for_is_told_and_the_guide_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with house(tmp_path) as opened, guide(opened, tmp_path):
        module = sys.modules["guide"]
        find = module.find

        async def lose(client: Client, kind: Any, engine_id: str = "") -> Any:
            if kind is Navigation:
                raise ConnectionLost("the connection was lost")
            return await find(client, kind, engine_id)

        await opened.hears()
        monkeypatch.setattr(module, "find", lose)
        opened.say("take me to the plant")
        await opened.tells("The robot is not free now. Ask me again later.")
        monkeypatch.setattr(module, "find", find)
        opened.say("take me to the plant")
        await opened.tells("Here we are: the plant.")


@pytest.mark.long
async def test_what_no_body_could_say_is_told_when_one_is_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async with house(tmp_path) as opened, voices_taken(opened) as ann, guide(opened, tmp_path) as running:
        monkeypatch.setattr("steady_voice.WAIT", 0.2)
        await opened.hears()
        opened.say("what can you do")
        printed: list[str] = []

        def has_given_up() -> bool:
            printed.append(capsys.readouterr().out)
            return "".join(printed).count("no body is free") == 2 or running.done()

        await until(has_given_up)
        await ann.release(AVATAR_VOICE)
        await opened.tells("I can lead you to: ", by="avatar")
        opened.say("take me to the plant")
        await opened.tells("Please follow the robot to the plant.", by="avatar")
        assert not [text for _, text in opened.told if "I can lead" in text]


@asynccontextmanager
async def voice_of_guide(opened: House) -> AsyncIterator[Any]:
    """Open the guide's voice alone."""
    async with Client(opened.guides.url, token=token("guide", rank="agent")) as client:
        voice = example("steady_voice").Voice(client)
        try:
            yield voice
        finally:
            await voice.rest()


@asynccontextmanager
async def voices_taken(opened: House) -> AsyncIterator[Client]:
    """Let a person have the voices of both bodies."""
    async with Client(opened.url, token=token("ann", rank="person")) as ann:
        await ann.bind(AVATAR_VOICE)
        await ann.bind(ROBOT_VOICE)
        yield ann


@pytest.mark.parametrize("then", ["", "What may I do for you?"])
async def test_what_a_body_did_not_say_that_was_lost_is_said_by_the_next_one_that_is_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, then: str
) -> None:
    async with house(tmp_path) as opened, voices_taken(opened) as ann, voice_of_guide(opened) as voice:
        with monkeypatch.context() as short:
            short.setattr("steady_voice.WAIT", 0.2)
            await voice.say("Hello!")
        await ann.release(AVATAR_VOICE)
        opened.synthesizer.seconds = 60.0
        saying = asyncio.ensure_future(voice.say(then))
        await opened.tells("Hello!", by="avatar")
        monkeypatch.setattr("steady_voice.WAIT", 0.2)
        opened.avatars.cut(refuse=True)
        await saying
        monkeypatch.undo()
        opened.synthesizer.seconds = 0.2
        await voice.say_late()
        assert opened.told == []
        await ann.release(ROBOT_VOICE)
        await voice.say_late()
        await opened.tells(f"Hello! {then}".strip(), by="robot")


async def test_what_the_guides_own_body_could_not_say_it_says_later(tmp_path: Path) -> None:
    async with (
        house(tmp_path) as opened,
        Client(opened.url, token=token("ann", rank="person")) as ann,
        voice_of_guide(opened) as voice,
    ):
        await ann.bind(ROBOT_VOICE)
        opened.synthesizer.refuses = True
        await voice.say("Hello!")
        opened.synthesizer.refuses = False
        assert voice.component_ref == AVATAR_VOICE
        await voice.say_late()
        await opened.tells("Hello!", by="avatar")


async def test_of_many_texts_that_no_body_could_say_the_last_ones_are_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async with house(tmp_path) as opened, voices_taken(opened) as ann, voice_of_guide(opened) as voice:
        with monkeypatch.context() as short:
            short.setattr("steady_voice.WAIT", 0.2)
            for text in ("One.", "Two.", "Three.", "Four."):
                await voice.say(text)
        await ann.release(AVATAR_VOICE)
        await voice.say_late()
        assert "avatar said: Two. Three. Four.\n" in capsys.readouterr().out


@pytest.mark.long
async def test_a_body_is_listened_to_again_where_that_failed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    subscribe, failures = ComponentProxy.event, [OutOfResources("too many subscriptions")]

    def event(component: ComponentProxy, name: str, *rest: Any) -> Any:
        if name == "heard" and failures:
            raise failures.pop()
        return subscribe(component, name, *rest)

    async with house(tmp_path) as opened:
        monkeypatch.setattr(ComponentProxy, "event", event)
        async with guide(opened, tmp_path):
            monkeypatch.setattr("guide.AGAIN", 0.1)
            await opened.hears()
            assert "avatar/hearing is not heard: " in capsys.readouterr().out
            opened.say("hello")
            await opened.tells("Hello!", by="avatar")


@pytest.mark.long
async def test_a_body_that_comes_after_the_start_is_listened_to(tmp_path: Path) -> None:
    async with house(tmp_path) as opened:
        opened.avatars.cut(refuse=True)
        await opened.leaves("avatar")
        async with guide(opened, tmp_path):
            opened.avatars.mend()
            await opened.hears()
            opened.say("hello")
            await opened.tells("Hello!")
