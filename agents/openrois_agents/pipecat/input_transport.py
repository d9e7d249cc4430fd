"""The input of a pipeline: it hears the visitor whom a body attends to."""

import asyncio
from collections.abc import Awaitable, Callable

from pipecat.frames.frames import CancelFrame, EndFrame, StartFrame, UserAudioRawFrame
from pipecat.transports.base_input import BaseInputTransport
from pipecat.transports.base_transport import TransportParams

from openrois_agents.voice.visitor_sound import VisitorSound

__all__ = ["VisitorInputTransport"]


class VisitorInputTransport(BaseInputTransport):
    """Hears the visitor whom a body attends to: frames of the visitor's sound, with the `visitor_ref` as `user_id`.

    Args:
        sound: open for as long as this is used, and read by nothing else; None to hear nothing.
        params: of the transport.
        tell_change: told whom the frames that follow are of; empty for silence. Frames wait for it.
    """

    def __init__(
        self, sound: VisitorSound | None, params: TransportParams, tell_change: Callable[[str], Awaitable[None]]
    ) -> None:
        super().__init__(params)
        self._sound = sound
        self._tell_change = tell_change
        self._heard = ""
        self._hearing: asyncio.Task[None] | None = None

    async def start(self, frame: StartFrame) -> None:
        """Begin to hear."""
        await super().start(frame)
        await self.set_transport_ready(frame)
        if self._sound is not None and self._hearing is None:
            self._hearing = self.create_task(self._hear(self._sound))

    async def stop(self, frame: EndFrame) -> None:
        """Hear no more."""
        await self._hear_no_more()
        await super().stop(frame)

    async def cancel(self, frame: CancelFrame) -> None:
        """Hear no more."""
        await self._hear_no_more()
        await super().cancel(frame)

    async def cleanup(self) -> None:
        """Hear no more, also where the pipeline has failed."""
        await self._hear_no_more()
        await super().cleanup()

    async def _hear(self, sound: VisitorSound) -> None:
        async for block in sound:
            if block.visitor_ref != self._heard:
                self._heard = block.visitor_ref
                await self._tell_change(block.visitor_ref)
            await self.push_audio_frame(
                UserAudioRawFrame(
                    audio=block.samples.tobytes(), sample_rate=sound.rate, num_channels=1, user_id=block.visitor_ref
                )
            )

    async def _hear_no_more(self) -> None:
        if self._hearing is not None:
            hearing, self._hearing = self._hearing, None
            await self.cancel_task(hearing)
