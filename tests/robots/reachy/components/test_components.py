"""The components of a Reachy Mini that are not in the suites of its behaviour: speech, sounds, states, refusals."""

import asyncio
import json
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from itertools import pairwise
from math import pi
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from openrois_body.components.reaction import reaction_ref
from openrois_body.speech.contract import Speech
from openrois_robots.reachy.adapter import linked_reachy
from openrois_robots.reachy.daemon.address import Address
from openrois_robots.reachy.options import ReachySettings
from openrois_robots.reachy.postures.gestures import Frame
from openrois_robots.reachy.postures.limits import MotionLimits
from openrois_robots.reachy.postures.posture import ASLEEP, NEUTRAL, Posture
from openrois_robots.reachy.voice import wave_file
from openrois_streaming.clock import SystemClock

from openrois.client import Client
from openrois.client.components import Move, SoundLocalization, SpeechSynthesis, SystemInformation
from openrois.errors import Aborted, ComponentFailed, OutOfResources, RoISError
from openrois.testing import harness
from tests.robots.reachy.behaviour_suite import react, turn
from tests.support.reachy import ALWAYS, Linked, daemon_process, linked, staged
from tests.support.robots import ended, until
from tests.support.voice import ScriptedSynthesizer

pytestmark = pytest.mark.extra(name="reachy")


@asynccontextmanager
async def speaking(seconds: float = 0.4, **options: Any) -> AsyncIterator[tuple[Linked, ScriptedSynthesizer]]:
    """Stage a robot whose texts take so long."""
    synthesizer = ScriptedSynthesizer(seconds)

    @asynccontextmanager
    async def made(_choice: object, _clock: object) -> AsyncIterator[ScriptedSynthesizer]:
        yield synthesizer

    with patch("openrois_body.speech_options.VoiceChoice.make", made):
        async with staged(has_media=True, **options) as stage:
            yield stage, synthesizer


async def say(client: Client, text: str = "one two three four") -> None:
    """Speak to the end."""
    speech = await client.find(SpeechSynthesis)
    async with speech.bound():
        await speech.set(speech_text=text)
        await client.run(speech.start())


class TestSpeech:
    async def test_a_text_is_uploaded_played_and_removed_and_takes_as_long_as_its_sound(self) -> None:
        async with speaking() as (stage, _):
            begun = time.monotonic()
            await say(stage.client)
            assert time.monotonic() - begun >= 0.4
            ((name, length, _),) = stage.daemon.sounds.played
            assert name.startswith("openrois-")
            assert length == pytest.approx(0.4, abs=0.001)
            assert stage.daemon.sounds.lengths == {}
            assert stage.daemon.sounds.silenced == []

    async def test_a_stopped_text_is_aborted_at_its_word_and_silent(self) -> None:
        async with speaking(4.0) as (stage, _):
            speech = await stage.client.find(SpeechSynthesis)
            async with speech.bound():
                await speech.set(speech_text="one two three four")
                talking = asyncio.create_task(stage.client.run(speech.start()))
                await until(lambda: stage.daemon.sounds.played)
                await stage.client.run(speech.stop())
                failure = await ended(talking)
            assert isinstance(failure, Aborted)
            assert "the speech was stopped at the word 'one' (character 0)" in str(failure)
            assert len(stage.daemon.sounds.silenced) == 1

    async def test_stop_reaches_the_sound(self) -> None:
        async with speaking(4.0) as (stage, _):
            speech = await stage.client.find(SpeechSynthesis)
            async with speech.bound():
                await speech.set(speech_text="one two three four")
                talking = asyncio.create_task(stage.client.run(speech.start()))
                await until(lambda: stage.daemon.sounds.played)
                begun = time.monotonic()
                await stage.client.control.stop_all()
                (silenced,) = stage.daemon.sounds.silenced
                print(f"STOP: the sound was stopped {1000 * (silenced - begun):.0f} ms later")
                assert isinstance(await ended(talking), Aborted)

    async def test_a_suspended_text_goes_on_where_it_was(self) -> None:
        async with speaking(1.0) as (stage, _):
            speech = await stage.client.find(SpeechSynthesis)
            async with speech.bound():
                await speech.set(speech_text="one two three four")
                talking = asyncio.create_task(stage.client.run(speech.start()))
                await until(lambda: stage.daemon.sounds.played)
                await stage.client.run(speech.suspend())
                await until(lambda: stage.daemon.sounds.silenced)
                await stage.client.run(speech.resume())
                assert await ended(talking) is None
            whole, rest = (length for _, length, _ in stage.daemon.sounds.played)
            assert whole == pytest.approx(1.0, abs=0.001)
            assert rest < 1.0

    async def test_texts_wait_for_each_other_and_not_without_a_bound(self) -> None:
        async with speaking(0.2) as (stage, _):
            voice = next(each for each in stage.robot.components if each.name == "speech_synthesizer")._voice  # type: ignore[attr-defined]
            options = {"ssml": False, "language": "en", "character": "default", "volume": 50}
            sayings = [asyncio.ensure_future(voice.say("one", **options)) for _ in range(33)]
            outcomes = asyncio.gather(*sayings, return_exceptions=True)
            await until(lambda: len(stage.daemon.sounds.played) == 2)
            (_, length, first), (_, _, second) = stage.daemon.sounds.played
            assert second - first >= length
            voice.interrupt("enough,")
            failures = [each for each in await outcomes if each is not None]
            assert sum(isinstance(each, OutOfResources) for each in failures) == 1
            assert any("enough, before the first word" in str(each) for each in failures)

    async def test_what_cannot_be_spoken_is_refused(self) -> None:
        async with speaking() as (stage, synthesizer):
            synthesizer.refuses = True
            with pytest.raises(RoISError, match="not available"):
                await say(stage.client)
            synthesizer.installed = False
            with pytest.raises(ComponentFailed, match=r"speech_synthesizer does not work now \(ERROR\): install it"):
                await say(stage.client)

    async def test_media_that_are_lost_end_what_waits_and_are_said(self) -> None:
        async with speaking(1.0) as (stage, _):
            first = asyncio.create_task(say(stage.client))
            await until(lambda: stage.daemon.sounds.played)
            stage.simulation.has_media = False
            await until(lambda: stage.robot.state.told.sound_problem)
            await ended(first)
            with pytest.raises(ComponentFailed, match="runs without media"):
                await say(stage.client)

    def test_a_sound_is_a_wav_file_of_every_second_sample(self) -> None:
        samples = np.arange(0, 4800, dtype=np.int16)
        data = wave_file(Speech(samples, (), ()))
        assert data[:4] == b"RIFF"
        assert np.array_equal(np.frombuffer(data[44:], "<i2"), samples[::2])


class TestSounds:
    async def test_a_voice_is_located_at_its_bearing(self) -> None:
        async with staged(sound_from=0.0) as stage:
            localizer = await stage.client.find(SoundLocalization)
            await until(lambda: _of(stage, "sound_localizer").status.value == "READY")
            async with localizer.sound_localized() as events:
                first = await anext(events)
                assert first.position_data == ("-1.000,0.000,-0.0000",)
                stage.simulation.sound_from = pi / 2
                second = await anext(events)
                assert second.position_data == ("0.000,1.000,-1.5708",)
                assert second.sound_ref == first.sound_ref


class TestStates:
    async def test_a_robot_that_is_not_there_is_uninitialized_with_a_reason(self) -> None:
        async with (
            linked_reachy("robot", ReachySettings(Address("127.0.0.1", 1)), SystemClock()) as robot,
            harness(*robot.components) as client,
        ):
            await until(lambda: "nothing listens" in robot.state.link.problem)
            asleep = [each for each in robot.components if each.name not in ALWAYS]
            assert {each.status.value for each in asleep} == {"UNINITIALIZED"}
            sentence = (
                "the Reachy Mini at 127.0.0.1:1 cannot be reached: nothing listens at this port; check --robot, and"
                " that the robot's daemon runs and listens to the network, not to its own machine alone"
                " (--fastapi-host 0.0.0.0)"
            )
            assert {each.problem() for each in asleep} == {sentence}
            with pytest.raises(ComponentFailed, match=r"is not connected yet \(UNINITIALIZED\): the Reachy"):
                await turn(client, 10)
            information = await client.find(SystemInformation)
            assert (await information.query("health"))["health"] == sentence
            for query in ("posture", "daemon"):
                with pytest.raises(ComponentFailed, match="nothing listens at this port"):
                    await information.query(query)
            with pytest.raises(ComponentFailed, match="nothing listens at this port"):
                await information.robot_position()

    async def test_a_daemon_that_does_not_run_is_an_error_with_its_state(self) -> None:
        async with staged() as stage:
            stage.simulation.state = "error"
            await until(lambda: not stage.robot.state.link.is_up)
            assert {each.status.value for each in stage.robot.components if each.name not in ALWAYS} == {"ERROR"}
            assert "does not run: its daemon is in the state 'error'" in _of(stage, "gaze").problem()
            stage.simulation.state = "running"
            await until(lambda: stage.robot.state.link.is_up)
            await turn(stage.client, 5)

    async def test_a_daemon_that_tells_nonsense_is_an_error_and_no_end_of_the_adapter(self) -> None:
        async with staged() as stage:
            link, socket = stage.robot.state.link, stage.robot.state.socket
            for nonsense in ("[]", '{"state": 1, "backend_status": [], "no_media": []}', "null"):
                with patch.object(stage.robot.state.daemon, "get", lambda _path, text=nonsense: _json(text)):
                    await until(lambda: not link.is_up)
                await until(lambda: link.is_up)
            for message in ("{", "[]", '{"type": "head_pose", "head_pose": [[1]]}', '{"type": "joint_positions"}'):
                socket._read(message)
            await turn(stage.client, 5)

    async def test_motors_that_take_no_targets_are_an_error_with_their_mode(self) -> None:
        async with staged() as stage:
            stage.simulation.motors = "gravity_compensation"
            await until(stage.robot.state.motor_problem)
            with pytest.raises(ComponentFailed, match="'gravity_compensation', in which they take no targets"):
                await turn(stage.client, 10)
            await react(stage.client, "wake_up")
            await turn(stage.client, 10)

    async def test_a_robot_that_sleeps_at_first_is_woken_from_where_it_is(self) -> None:
        async with staged(posture=ASLEEP, motors="disabled") as stage:
            # A busy machine may tell no postures for a moment: then nothing is ready.
            await until(lambda: _of(stage, "reaction").status.value == "READY")
            assert _of(stage, "gaze").status.value == "ERROR"
            await react(stage.client, "wake_up")
            await until(lambda: _of(stage, "gaze").status.value == "READY")
            seen = [posture for _, posture in stage.daemon.positions]
            assert max(abs(one.left - other.left) for one, other in pairwise(seen)) < 0.1

    async def test_a_head_that_is_held_ends_the_motion_with_a_reason(self) -> None:
        async with staged(is_held=True) as stage:
            with pytest.raises(ComponentFailed, match="does not follow: another program moves it, or something holds"):
                await react(stage.client, "look_around")
            assert stage.robot.motion.figures.unfollowed == 1

    async def test_a_daemon_that_hangs_ends_the_motion_and_is_back_by_itself(self) -> None:
        async with daemon_process() as daemon, linked(daemon.address) as robot, harness(*robot.components) as client:
            reacting = asyncio.create_task(react(client, "look_around"))
            await until(lambda: robot.motion.figures.targets > 10)
            frozen = time.monotonic()
            daemon.freeze()
            failure = await ended(reacting)
            print(f"the motion ended {time.monotonic() - frozen:.2f} s after the daemon was frozen")
            assert isinstance(failure, ComponentFailed)
            await until(lambda: not robot.state.link.is_up)
            daemon.thaw()
            await until(lambda: robot.state.link.is_up)
            await turn(client, 5)


class TestMoves:
    async def test_a_turn_takes_its_time_and_none_that_is_too_fast(self) -> None:
        async with staged() as stage:
            move = await stage.client.find(Move)
            async with move.bound():
                await move.set(line=[0, 10], time=1000)
                begun = time.monotonic()
                await stage.client.run(move.start())
                assert time.monotonic() - begun >= 1.0
                with pytest.raises(RoISError, match="90 degrees in 100 ms are 16 rad/s; the speed must be"):
                    await move.set(line=[0, 90], time=100)
                with pytest.raises(RoISError, match="a Reachy Mini stands on its foot: set line to"):
                    await move.set(curve=[100, 90])
                with pytest.raises(RoISError, match="expected two numbers"):
                    await move.set(line=[1])
                with pytest.raises(RoISError, match="expected at most 309 degrees, not 400"):
                    await move.set(line=[0, 400])

    async def test_slower_limits_are_kept(self) -> None:
        async with staged() as stage, linked(stage.address, "slow", motion=MotionLimits(0.3, 0.2, 0.5)) as slow:
            since = len(stage.daemon.positions)
            await slow.motion.perform("test", "turn", (Frame(NEUTRAL),), 0.1)
            seen = [posture.body for _, posture in stage.daemon.positions[since:]]
            assert max(abs(one - other) for one, other in pairwise(seen)) < 0.012

    async def test_a_gesture_is_played_where_the_body_is_turned(self) -> None:
        async with staged(posture=replace(Posture(), body=0.8)) as stage:
            await react(stage.client, "nod")
            assert {round(posture.body, 6) for _, posture in stage.daemon.positions} == {0.8}

    async def test_without_a_reaction_there_is_nothing_to_play(self) -> None:
        async with staged() as stage:
            with pytest.raises(RoISError, match="there is no reaction"):
                await react(stage.client, "fly")
            assert reaction_ref("greet") == "urn:x-rois:def:reaction:OpenRoIS::greet"


def _of(stage: Linked, name: str) -> Any:
    return next(each for each in stage.robot.components if each.name == name)


async def _json(text: str) -> Any:
    return json.loads(text)
