"""The viewer, a process of its own: a measuring sink that is asked through pipes. Run by `__main__`."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import asdict
from typing import Any

from openrois_streaming.testing import MeasuringSink

from openrois_bench.processes.partner import serve
from openrois_bench.streams.lipsync.mouth import Mouth


@asynccontextmanager
async def _role() -> AsyncIterator[Mapping[str, Any]]:
    mouth = Mouth()
    async with MeasuringSink(on_media=mouth.add_frame) as sink:

        async def answer(params: dict[str, Any]) -> str:
            return await sink.answer(params["sdp"])

        async def restart(_params: dict[str, Any]) -> None:
            sink.restart()
            mouth.restart()

        async def read(_params: dict[str, Any]) -> dict[str, Any]:
            played, told = sink.lip_sync(), sink.told_lip_sync()
            return {
                "played": None if played is None else asdict(played),
                "told": None if told is None else asdict(told),
                "mouth": mouth.figures(),
                "pictures": asdict(sink.pictures()),
                "sound": asdict(sink.sound()),
            }

        yield {"answer": answer, "restart": restart, "read": read}


if __name__ == "__main__":
    serve(_role)
