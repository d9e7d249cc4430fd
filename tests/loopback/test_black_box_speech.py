"""Speech into a microphone is notified to an application, with a network, a codec and a gateway between."""

from collections.abc import AsyncIterator

import pytest

from tests.support.black_box import AUDIO, Application, Message, application
from tests.support.black_box_media import Voice
from tests.support.demo import Demo
from tests.support.hearing import spoken, stereo_48k

pytestmark = pytest.mark.media

SPEECH, HEARING = "avatar/speech_recognizer", "avatar/hearing"
GRAMMAR = "#JSGF V1.0;\ngrammar robot;\npublic <command> = go to the (window | door) | turn (left | right) | stop;\n"


@pytest.fixture
async def app(demo: Demo, flite: None, pocketsphinx: None) -> AsyncIterator[Application]:
    async with application(demo.url) as connected:
        await connected.hello()
        connected.devices = {"audio": Voice(stereo_48k(spoken("go to the window"))[:, 0])}
        yield connected


class Events:
    """Events in the order in which they are received, with their results."""

    def __init__(self, app: Application) -> None:
        self._app = app
        self._read = 0

    async def next(self) -> tuple[str, dict[str, str]]:
        await self._app.news.until(lambda: len(self._app.told("rois.event.notify_event")) > self._read, 20)
        notice = self._app.told("rois.event.notify_event")[self._read]
        self._read += 1
        detail = await self._app.ask("rois.event.get_event_detail", event_id=notice["event_id"])
        return notice["event_type"], {each["name"]: each["value"] for each in detail["results"]}


async def test_phrase_is_recognised_while_subscribed(app: Application) -> None:
    parameter: Message = {"name": "grammar", "data_type_ref": "string", "value": GRAMMAR}
    answer = await app.ask("rois.command.set_parameter", component_ref=SPEECH, parameters=[parameter])
    assert answer["return_code"] == "OK", answer
    subscriptions = []
    for ref, event_type in (
        (SPEECH, "speech_input_started"),
        (SPEECH, "speech_input_finished"),
        (SPEECH, "speech_recognized"),
        (HEARING, "heard"),
    ):
        subscribed = await app.ask("rois.event.subscribe", event_type=event_type, condition=f"component_ref = '{ref}'")
        assert subscribed["return_code"] == "OK", subscribed
        subscriptions.append(subscribed["subscribe_id"])
    microphone = await app.play(AUDIO, direction="sendonly")
    events, told = Events(app), list[tuple[str, dict[str, str]]]()
    while not told or told[-1][0] != "speech_recognized":
        told.append(await events.next())
    types = [event_type for event_type, _ in told]
    assert types[0] == "speech_input_started"
    assert "speech_input_finished" in types
    assert told[-1][1]["recognized_text"] == '["go to the window"]'
    assert any(values["final"] == "false" for event_type, values in told if event_type == "heard")
    for subscribe_id in subscriptions:
        assert (await app.ask("rois.event.unsubscribe", subscribe_id=subscribe_id))["return_code"] == "OK"
    assert await app.act("disconnect", microphone) == "OK"
