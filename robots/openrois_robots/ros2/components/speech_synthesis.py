"""SpeechSynthesis by a node of the robot: a topic or a service that takes texts (component 11)."""

import asyncio
from typing import Annotated, Any, Final

from openrois_streaming.clock import MediaClock
from pydantic import Field

from openrois.adapter import BadParameter, ComponentFailed, components, parameter
from openrois_robots.ros2.components.bound import Bound, Ends
from openrois_robots.ros2.graph.backend import Publisher, ServiceClient
from openrois_robots.ros2.mapping.settings import Speech

__all__ = ["SpeechSynthesis"]

BEGIN_TIMEOUT: Final = 5.0
"""Seconds within which a robot that tells when it speaks has to begin."""
SPEECH_TIMEOUT: Final = 120.0
"""Seconds within which it has to end."""


class SpeechSynthesis(Bound, components.SpeechSynthesis, omit=("ssml_text", "volume", "language", "character")):
    """Has `speech_text` spoken by the robot's own voice.

    `completed` comes when a service has answered, or when the robot tells that it has ended. Where a topic takes texts
    and nothing tells of their end, it comes when a node has been sent the text.

    Args:
        settings: of the speech.
        mouth: takes texts.
        hush: makes the robot fall silent; None: it cannot be stopped.
        ends: that it needs.
        clock: the media clock.
    """

    speech_text: Annotated[str, Field(max_length=4000)] | None = parameter(None)

    def __init__(
        self,
        settings: Speech,
        mouth: Publisher | ServiceClient,
        hush: Publisher | None,
        ends: Ends,
        clock: MediaClock,
    ) -> None:
        super().__init__()
        self.ends = ends
        self._settings = settings
        self._mouth = mouth
        self._hush = hush
        self._clock = clock
        self._is_speaking = False
        self._changed = asyncio.Event()

    async def synthesizable_languages(self) -> tuple[str, ...]:
        """Return the languages of the mapping file."""
        return tuple(each.strip() for each in self._settings.languages.split(","))

    async def start(self) -> None:
        """Speak to the end, as far as the robot tells it.

        Raises:
            BadParameter: no text is set.
            ComponentFailed: the robot refused the text, is lost, or does not begin or end.
        """
        if not self.speech_text:
            raise BadParameter("speech_text is not set; set it before start")
        await self.ends.link.during(self._say(self.speech_text))

    async def stop(self) -> None:
        """Let the robot fall silent.

        Raises:
            ComponentFailed: the mapping file names no topic that makes it do so, or no node hears it: it speaks to its
                end.
        """
        problem = "the mapping file has no speech.hush" if self._hush is None else self._hush.problem
        if problem or self._hush is None:
            raise ComponentFailed(f"the robot's voice cannot be stopped: {problem}")
        self._hush.publish({})

    def take_speaking(self, message: Any) -> None:
        """Note whether the robot speaks: a `std_msgs/msg/Bool`."""
        self._is_speaking = bool(message.data)
        self._changed.set()

    async def _say(self, text: str) -> None:
        fields = {self._settings.text: text}
        try:
            if hasattr(self._mouth, "call"):
                _check_response(await self._mouth.call(fields, SPEECH_TIMEOUT))
                return
            self._mouth.publish(fields)
        except ValueError as error:
            raise ComponentFailed(f"the robot's voice cannot be told a text: {error}; see speech.text") from None
        if self._settings.speaking:
            await self._until(True, BEGIN_TIMEOUT, "begun")
            await self._until(False, SPEECH_TIMEOUT, "ended")

    async def _until(self, is_speaking: bool, seconds: float, what: str) -> None:
        late = asyncio.ensure_future(self._clock.sleep_until(self._clock.now() + seconds))
        told = asyncio.ensure_future(self._told(is_speaking))
        try:
            await asyncio.wait({late, told}, return_when=asyncio.FIRST_COMPLETED)
            if not told.done():
                raise ComponentFailed(f"the robot has not {what} to speak within {seconds:g} s")
        finally:
            late.cancel()
            told.cancel()

    async def _told(self, is_speaking: bool) -> None:
        """Return when the robot tells that it speaks, or does not."""
        while self._is_speaking is not is_speaking:
            self._changed.clear()
            await self._changed.wait()


def _check_response(response: Any) -> None:
    """Raise `ComponentFailed` where the response of a service says that it has not succeeded."""
    if getattr(response, "success", True) is False:
        raise ComponentFailed(getattr(response, "message", "") or "the robot could not speak the text")
