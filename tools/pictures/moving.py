"""A moving picture of the page: what Chromium shows, as an animated WebP."""

import asyncio
import base64
import io
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import av
from playwright.async_api import Page

__all__ = ["Film", "filming"]

RATE: Final = 8
"""Pictures a second."""
WIDTH, HEIGHT = 800, 500
QUALITY: Final = 90
"""Of 100."""


@dataclass
class Film:
    """The pictures that the browser has shown, each with the second in which it came."""

    shown: list[tuple[float, bytes]] = field(default_factory=list)

    def write(self, path: Path) -> None:
        """Write what was shown at an even pace, endlessly repeated."""
        with av.open(str(path), "w", format="webp", options={"loop": "0"}) as file:
            stream = file.add_stream("libwebp_anim", rate=RATE, options={"quality": str(QUALITY), "lossless": "0"})
            stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "bgra"
            for number, picture in enumerate(self._even()):
                with av.open(io.BytesIO(picture), "r") as still:
                    frame = next(still.decode(video=0)).reformat(WIDTH, HEIGHT, "bgra")
                frame.pts, frame.time_base = number, Fraction(1, RATE)
                file.mux(stream.encode(frame))
            file.mux(stream.encode(None))

    def _even(self) -> Iterator[bytes]:
        begin, end = self.shown[0][0], self.shown[-1][0]
        for number in range(round((end - begin) * RATE)):
            yield max(each for each in self.shown if each[0] <= begin + number / RATE)[1]


@asynccontextmanager
async def filming(page: Page) -> AsyncIterator[Film]:
    """Keep what the browser shows while the block runs."""
    film = Film()
    session = await page.context.new_cdp_session(page)
    replies: set[asyncio.Task[Any]] = set()

    def take(shown: dict[str, Any]) -> None:
        film.shown.append((float(shown["metadata"]["timestamp"]), base64.b64decode(shown["data"])))
        reply = asyncio.ensure_future(session.send("Page.screencastFrameAck", {"sessionId": shown["sessionId"]}))
        replies.add(reply)
        reply.add_done_callback(replies.discard)

    session.on("Page.screencastFrame", take)
    await session.send("Page.startScreencast", {"format": "jpeg", "quality": 92, "everyNthFrame": 1})
    try:
        yield film
    finally:
        await session.send("Page.stopScreencast")
        await asyncio.gather(*replies, return_exceptions=True)
        await session.detach()
