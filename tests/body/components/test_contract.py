"""The avatar's components keep the contract of every component."""

from collections.abc import Mapping

from openrois_avatar.components.viewpoint import Viewpoint
from openrois_body.body import Body
from openrois_body.components.dialogue import Dialogue
from openrois_body.components.gaze import Gaze
from openrois_body.components.operator import Operator
from openrois_body.components.reaction import Reaction, reaction_ref
from openrois_body.components.scene_senses import (
    ScenePersonDetection,
    ScenePersonLocalization,
    SceneSoundLocalization,
)
from openrois_body.components.speech_progress import SpeechProgress
from openrois_body.components.speech_stream import SpeechStream
from openrois_body.components.speech_synthesis import SpeechSynthesis
from openrois_body.components.system_information import SystemInformation
from openrois_body.messages import Thing
from openrois_body.microphone_senses import microphone_senses
from openrois_body.motion.world import World
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.speech_control import SpeechControl
from openrois_body.speech.voice import Voice
from openrois_media.components import AudioStreaming, VideoStreaming
from openrois_media.devices import Camera, Microphone

from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.testing import ComponentContract
from openrois.types.codes import ComponentStatus
from tests.body.components.test_speech_progress import Attention
from tests.support.listening import ScriptedRecognizer
from tests.support.streaming import VirtualClock
from tests.support.voice import ScriptedSynthesizer
from tests.support.walker import Walking


def ready() -> ComponentStatus:
    return ComponentStatus.READY


class TestSystemInformation(ComponentContract):
    async def component(self) -> Component:
        return SystemInformation("avatar", ready)


class TestSpeechSynthesis(ComponentContract):
    parameters: Mapping[str, str] = {"speech_text": "Hello"}

    async def component(self) -> Component:
        clock = VirtualClock()
        return SpeechSynthesis(Voice(ScriptedSynthesizer(), BodySound(clock), Body(lambda _command: None)))


class TestNavigation(ComponentContract):
    parameters: Mapping[str, str] = {"target_positions": '["1,0","0,1,0.5"]'}

    async def component(self) -> Component:
        return Walking().navigation


class TestMove(ComponentContract):
    parameters: Mapping[str, str] = {"line": "[1000,90]"}

    async def component(self) -> Component:
        return Walking().move


class TestFollow(ComponentContract):
    parameters: Mapping[str, str] = {"target_object_ref": "anna", "distance": "500"}

    async def component(self) -> Component:
        walking = Walking()
        walking.populate(Thing("anna", "person", 3, 0))
        return walking.follow


class TestScenePersonDetection(ComponentContract):
    async def component(self) -> Component:
        return ScenePersonDetection(World("avatar"), VirtualClock(), ready)


class TestScenePersonLocalization(ComponentContract):
    parameters: Mapping[str, str] = {"detection_threshold": "50", "minimum_interval": "100"}

    async def component(self) -> Component:
        return ScenePersonLocalization(World("avatar"), VirtualClock(), ready)


class TestSceneSoundLocalization(TestScenePersonLocalization):
    async def component(self) -> Component:
        return SceneSoundLocalization(World("avatar"), VirtualClock(), ready)


class TestSpeechProgress(ComponentContract):
    async def component(self) -> Component:
        voice = Voice(ScriptedSynthesizer(), BodySound(VirtualClock()), Body(lambda _command: None))
        return SpeechProgress(voice, Attention())


class TestDialogue(ComponentContract):
    async def component(self) -> Component:
        return Dialogue()


class TestSpeechStream(ComponentContract):
    async def component(self) -> Component:
        clock = VirtualClock()
        voice = Voice(ScriptedSynthesizer(), BodySound(clock), Body(lambda _command: None))
        return SpeechStream(SpeechControl("avatar/speech_stream", voice, clock, TaskScope()))


class TestReaction(ComponentContract):
    parameters: Mapping[str, str] = {"reaction_ref": reaction_ref("nod")}

    async def component(self) -> Component:
        return Reaction(Body(lambda _command: None), lambda: ("nod", "wave"), ready)


class TestGaze(ComponentContract):
    async def component(self) -> Component:
        return Gaze(Body(lambda _command: None), ready)


class TestViewpoint(ComponentContract):
    async def component(self) -> Component:
        return Viewpoint(Body(lambda _command: None), lambda: ("face", "room"), ready)


class TestOperator(ComponentContract):
    refuses: Mapping[str, str] = {"camera": "no camera is connected"}

    async def component(self) -> Component:
        return Operator(Microphone(VirtualClock()), Camera())


def hearing(name: str) -> Component:
    senses = microphone_senses("avatar", Microphone(VirtualClock()), VirtualClock(), ScriptedRecognizer())
    (component,) = (each for each in senses.components if each.name == name)
    return component


class TestSoundDetection(ComponentContract):
    async def component(self) -> Component:
        return hearing("sound_detecter")


class TestSoundLocalization(ComponentContract):
    async def component(self) -> Component:
        return hearing("sound_localizer")


class TestSpeechRecognition(ComponentContract):
    async def component(self) -> Component:
        return hearing("speech_recognizer")


class TestHearing(ComponentContract):
    async def component(self) -> Component:
        return hearing("hearing")


STREAMS = "a stream belongs to the application that connects it, and a component is not told which one that is"


class TestVideoStreaming(ComponentContract):
    refuses: Mapping[str, str] = {"get_stream_status": STREAMS}

    async def component(self) -> Component:
        return VideoStreaming(("video/VP8",), ("recvonly",), ready)


class TestAudioStreaming(ComponentContract):
    refuses: Mapping[str, str] = {"get_stream_status": STREAMS}

    async def component(self) -> Component:
        return AudioStreaming(("audio/opus",), ("recvonly",), ready)
