"""SpeechSynthesis by a topic or a service of the robot."""

import asyncio
from typing import Any

import pytest

from openrois.client.components import SpeechSynthesis
from openrois.errors import Aborted, ComponentFailed
from tests.support.ros_robot import MAPPING, Stage, message, staged

pytestmark = pytest.mark.extra(name="ros2")


async def begun(stage: Stage, text: str = "Hello.") -> "asyncio.Future[Any]":
    speech = await stage.client.find(SpeechSynthesis)
    await speech.bind()
    await speech.set(speech_text=text)
    return await stage.begun(stage.client.run(speech.start()), 0.1)


def without(key: str) -> dict[str, Any]:
    speech = {name: value for name, value in MAPPING["speech"].items() if name != key}
    return {**MAPPING, "speech": speech}


async def test_it_is_completed_when_the_robot_has_spoken() -> None:
    async with staged() as stage:
        going = await begun(stage)
        assert stage.graph.published[-1] == ("/say", {"data": "Hello."})
        await stage.run(2.0)
        assert not going.done()
        stage.graph.say("/speaking", message(data=True))
        await stage.run(2.0)
        assert not going.done()
        stage.graph.say("/speaking", message(data=False))
        await stage.until(going, 1.0)


async def test_a_robot_that_does_not_begin_is_said() -> None:
    async with staged() as stage:
        going = await begun(stage)
        with pytest.raises(ComponentFailed, match="has not begun to speak within 5 s"):
            await stage.until(going, 6.0)


async def test_a_robot_that_tells_nothing_is_sent_the_text() -> None:
    async with staged(without("speaking")) as stage:
        await stage.until(await begun(stage), 1.0)


async def test_a_stop_silences_a_robot_that_can_be_silenced() -> None:
    async with staged() as stage:
        going = await begun(stage)
        stage.graph.say("/speaking", message(data=True))
        speech = await stage.client.find(SpeechSynthesis)
        await stage.until(stage.client.run(speech.stop()), 1.0)
        assert ("/hush", {}) in stage.graph.published
        with pytest.raises(Aborted):
            await stage.until(going, 1.0)


async def test_a_stop_of_one_that_cannot_be_is_said_and_does_not_look_like_success() -> None:
    async with staged(without("hush")) as stage:
        going = await begun(stage)
        speech = await stage.client.find(SpeechSynthesis)
        with pytest.raises(ComponentFailed, match=r"cannot be stopped: the mapping file has no speech\.hush"):
            await stage.until(stage.client.run(speech.stop()), 1.0)
        assert not going.done()
        stage.graph.say("/speaking", message(data=True))
        await stage.run(0.1)
        stage.graph.say("/speaking", message(data=False))
        await stage.until(going, 1.0)


async def test_a_stop_that_no_node_hears_does_not_look_like_success() -> None:
    async with staged(problems={"/hush": "no node subscribes to /hush"}) as stage:
        going = await begun(stage)
        stage.graph.say("/speaking", message(data=True))
        speech = await stage.client.find(SpeechSynthesis)
        with pytest.raises(ComponentFailed, match="the robot's voice cannot be stopped: no node subscribes to /hush"):
            await stage.until(stage.client.run(speech.stop()), 1.0)
        assert not going.done()


async def test_speech_leaves_no_task_behind() -> None:
    async with staged() as stage:
        before = len(asyncio.all_tasks())
        going = await begun(stage)
        for is_speaking in (False, False, True, True):
            stage.graph.say("/speaking", message(data=is_speaking))
            await stage.run(0.1)
        speech = await stage.client.find(SpeechSynthesis)
        await stage.until(stage.client.run(speech.stop()), 1.0)
        with pytest.raises(Aborted):
            await stage.until(going, 1.0)
        await stage.run(0.5)
        assert len(asyncio.all_tasks()) <= before


@pytest.mark.parametrize(
    ("response", "said"),
    [
        (message(success=True, message=""), ""),
        (message(ok=1), ""),
        (message(success=False, message="no voice"), "no voice"),
        (message(success=False), "the robot could not speak the text"),
    ],
)
async def test_a_service_says_how_it_went(response: Any, said: str) -> None:
    mapping = {**MAPPING, "speech": {"service": "say", "type": "kit_msgs/srv/Say", "text": "text"}}
    async with staged(mapping) as stage:
        stage.graph.answers["/say"] = answer = asyncio.get_running_loop().create_future()
        going = await begun(stage)
        assert stage.graph.published[-1] == ("/say", {"text": "Hello."})
        assert not going.done()
        answer.set_result(response)
        if said:
            with pytest.raises(ComponentFailed, match=said):
                await stage.until(going, 1.0)
        else:
            await stage.until(going, 1.0)


async def test_a_field_that_the_type_lacks_is_said() -> None:
    async with staged() as stage:

        def refuse(_message: object) -> None:
            raise ValueError("std_msgs/msg/String has no field 'data'")

        stage.component("speech_synthesizer")._mouth.publish = refuse
        going = await begun(stage)
        with pytest.raises(ComponentFailed, match=r"has no field 'data'; see speech\.text"):
            await stage.until(going, 1.0)


async def test_it_names_the_languages_of_the_mapping() -> None:
    async with staged({**MAPPING, "speech": {"topic": "say", "languages": "en, ja"}}) as stage:
        speech = await stage.client.find(SpeechSynthesis)
        assert await speech.synthesizable_languages() == ("en", "ja")


async def test_without_a_text_there_is_nothing_to_say() -> None:
    async with staged() as stage:
        speech = await stage.client.find(SpeechSynthesis)
        async with speech.bound():
            with pytest.raises(ComponentFailed, match="speech_text is not set"):
                await stage.client.run(speech.start())
