"""SpeechSynthesis as an engine sees it."""

import asyncio
import json

import pytest
from openrois_body.body import Body
from openrois_body.components.speech_synthesis import SpeechSynthesis
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.voice import Voice

from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed
from openrois.types.messages import Argument, Result
from tests.support.streaming import VirtualClock, settle
from tests.support.voice import ScriptedSynthesizer

REF = "avatar/speech_synthesizer"


class Stage:
    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.synthesizer = ScriptedSynthesizer()
        voice = Voice(self.synthesizer, BodySound(self.clock), Body(lambda _command: None))
        self.registry = LocalRegistry("avatar", [SpeechSynthesis(voice)])

    async def set(self, **values: str) -> None:
        arguments = tuple(Argument(name=name, data_type_ref="string", value=value) for name, value in values.items())
        await self.registry.invoke(REF, "set_parameter", arguments)

    async def ask(self, query: str) -> dict[str, str]:
        return {result.name: result.value for result in await self.registry.query(REF, query)}

    def start(self) -> "asyncio.Future[tuple[Result, ...]]":
        return asyncio.ensure_future(self.registry.invoke(REF, "start"))


@pytest.fixture
def stage() -> Stage:
    return Stage()


async def test_a_text_is_spoken_with_its_parameters(stage: Stage) -> None:
    await stage.set(speech_text="Guten Tag", language="de", volume="70", character="f1")
    speaking = stage.start()
    await settle()
    assert await stage.ask("component_status") == {"status": "BUSY"}
    await stage.clock.advance(1.5)
    assert await speaking == ()
    assert stage.synthesizer.asked == [("Guten Tag", "de", "f1", 70, False)]


async def test_stop_ends_a_text_with_abort(stage: Stage) -> None:
    await stage.set(speech_text="A long story")
    speaking = stage.start()
    await settle()
    await stage.registry.invoke(REF, "stop")
    with pytest.raises(Aborted):
        await speaking


async def test_the_text_that_was_set_last_is_spoken(stage: Stage) -> None:
    await stage.set(speech_text="plain")
    await stage.set(ssml_text="<speak>marked up</speak>")
    stage.start()
    await settle()
    await stage.set(speech_text="plain again")
    assert (await stage.ask("get_parameter"))["speech_text"] == "plain again"
    assert "ssml_text" not in await stage.ask("get_parameter")
    assert stage.synthesizer.asked == [("<speak>marked up</speak>", "en", None, 50, True)]


@pytest.mark.parametrize(
    "values",
    [
        {"speech_text": "a", "ssml_text": "<speak>b</speak>"},
        {"speech_text": "x" * 4001},
        {"volume": "101"},
        {"volume": "-1"},
        {"volume": "loud"},
        {"pitch": "high"},
    ],
)
async def test_parameters_that_cannot_be_used_are_refused_and_nothing_is_stored(
    stage: Stage, values: dict[str, str]
) -> None:
    before = await stage.ask("get_parameter")
    with pytest.raises(BadParameter):
        await stage.set(language="de", **values)
    assert await stage.ask("get_parameter") == before


async def test_without_a_text_there_is_nothing_to_start(stage: Stage) -> None:
    with pytest.raises(BadParameter, match="speech_text"):
        await stage.start()


@pytest.mark.parametrize(("old", "new"), [("ssml_text", "speech_text"), ("speech_text", "ssml_text")])
async def test_an_empty_text_takes_the_place_of_the_other_one_too(stage: Stage, old: str, new: str) -> None:
    await stage.set(**{old: "said before"})
    await stage.set(**{new: ""})
    speaking = stage.start()
    await settle()
    assert stage.synthesizer.asked == []
    with pytest.raises(BadParameter, match="neither speech_text nor ssml_text is set; set one of them before start"):
        await speaking


async def test_languages_and_characters_are_listed(stage: Stage) -> None:
    assert json.loads((await stage.ask("synthesizable_languages"))["languages"]) == ["en", "de"]
    assert json.loads((await stage.ask("available_voices"))["characters"]) == ["default", "f1", "m1"]


async def test_where_speech_is_not_installed_the_component_says_error(stage: Stage) -> None:
    stage.synthesizer.installed = False
    assert await stage.ask("component_status") == {"status": "ERROR"}
    await stage.set(speech_text="Hello")
    with pytest.raises(ComponentFailed):
        await stage.start()
