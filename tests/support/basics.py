"""The seventeen basic components, each written as an adapter's author would, as simple as it can be."""

import asyncio
from datetime import UTC, datetime

from openrois.adapter import BadParameter, Component, ComponentStatus, StreamStatus, components
from openrois.catalog.system_information import EngineStatusResult, RobotPositionResult

NOON = datetime(2026, 6, 1, 12, tzinfo=UTC)


class SystemInformation(components.SystemInformation):
    async def robot_position(self) -> RobotPositionResult:
        return RobotPositionResult(position_data=("0.0,0.0,0.0",), robot_ref=("robot",), timestamp=NOON)

    async def engine_status(self) -> EngineStatusResult:
        return EngineStatusResult(status=ComponentStatus.READY, operable_time=NOON)


class PersonDetection(components.PersonDetection):
    """Detects one more person at each start."""

    persons = 0

    async def start(self) -> None:
        self.persons += 1
        self.person_detected(self.persons)

    async def stop(self) -> None:
        self.persons = 0


class PersonLocalization(components.PersonLocalization, omit=("detection_threshold",)):
    async def start(self) -> None:
        self.person_localized(("alice",), ("1.0,2.0,0.5",))

    async def stop(self) -> None: ...


class PersonIdentification(components.PersonIdentification):
    async def start(self) -> None:
        self.person_identified(("alice",), NOON)

    async def stop(self) -> None: ...


class FaceDetection(components.FaceDetection):
    async def start(self) -> None:
        self.face_detected(1)

    async def stop(self) -> None: ...


class FaceLocalization(components.FaceLocalization):
    async def start(self) -> None:
        self.face_localized(("face",), ("1.0,2.0,0.5",))

    async def stop(self) -> None: ...


class SoundDetection(components.SoundDetection):
    async def start(self) -> None:
        self.sound_detected(1)

    async def stop(self) -> None: ...


class SoundLocalization(components.SoundLocalization, omit=("detection_threshold", "minimum_interval")):
    async def start(self) -> None:
        self.sound_localized(("sound",), ("1.0,2.0,0.5",))

    async def stop(self) -> None: ...


class SpeechRecognition(components.SpeechRecognition):
    """Listens until it is stopped."""

    async def start(self) -> None:
        self.speech_input_started()
        try:
            await asyncio.Event().wait()
        finally:
            self.speech_input_finished()
            self.speech_recognized(("hello",))

    async def stop(self) -> None: ...

    async def recognizable_languages(self) -> tuple[str, ...]:
        return ("en", "ja")


class GestureRecognition(components.GestureRecognition):
    def __init__(self) -> None:
        super().__init__()
        self.recognizable_gestures = ("wave",)

    async def start(self) -> None:
        self.gesture_recognized(("wave",))

    async def stop(self) -> None: ...


class SpeechSynthesis(components.SpeechSynthesis):
    async def start(self) -> None:
        if not self.speech_text and not self.ssml_text:
            raise BadParameter("set speech_text or ssml_text first")

    async def stop(self) -> None: ...

    async def synthesizable_languages(self) -> tuple[str, ...]:
        return ("en",)

    async def available_voices(self) -> tuple[str, ...]:
        return (self.character,)


class Reaction(components.Reaction):
    async def start(self) -> None: ...

    async def stop(self) -> None: ...

    async def available_reactions(self) -> tuple[str, ...]:
        return ("nod",)


class Navigation(components.Navigation):
    """Arrives at once."""

    async def start(self) -> None:
        *waypoints, destination = self.target_positions or ("home",)
        for target in waypoints:
            self.reached_target(target, is_final_target=False)
        self.reached_target(destination, is_final_target=True)

    async def stop(self) -> None: ...


class Follow(components.Follow):
    """Follows until it is stopped."""

    async def start(self) -> None:
        await asyncio.Event().wait()

    async def stop(self) -> None: ...

    async def suspend(self) -> None: ...

    async def resume(self) -> None: ...


class Move(components.Move):
    async def start(self) -> None: ...

    async def stop(self) -> None: ...


class AudioStreaming(components.AudioStreaming):
    """One stream shared by all applications."""

    async def connect_stream(self) -> str:
        self.notify_stream_status(StreamStatus.STREAMING_RUNNING, stream_id="stream")
        return "stream"

    async def disconnect_stream(self, stream_id: str) -> None: ...

    async def get_stream_status(self) -> StreamStatus:
        return StreamStatus.STREAMING_RUNNING


class VideoStreaming(components.VideoStreaming):
    async def connect_stream(self) -> str:
        return "stream"

    async def disconnect_stream(self, stream_id: str) -> None: ...


BASICS: tuple[type[Component], ...] = (
    SystemInformation,
    PersonDetection,
    PersonLocalization,
    PersonIdentification,
    FaceDetection,
    FaceLocalization,
    SoundDetection,
    SoundLocalization,
    SpeechRecognition,
    GestureRecognition,
    SpeechSynthesis,
    Reaction,
    Navigation,
    Follow,
    Move,
    AudioStreaming,
    VideoStreaming,
)
