"""The WebSocket itself: frames, sizes and closing."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import suppress
from typing import Final

from websockets.exceptions import ConnectionClosed

from openrois_conformance.deviation import Deviation, expect
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

CONNECT: Final = {"jsonrpc": "2.0", "id": "c", "method": "rois.system.connect"}
_TOO_LONG: Final = 8 << 20
_LONG: Final = 32 << 10


@CHECKS("frames-text")
async def _frames_text(stage: Stage) -> None:
    """The gateway sends text frames, one JSON-RPC object each."""
    app = await stage.application()
    for method in ("rois.system.connect", "rois.system.get_profile", "rois.command.search"):
        await app.granted(method)


@CHECKS("frames-binary")
async def _frames_binary(stage: Stage) -> None:
    """A binary frame is refused with 1003, or read as text; others are served on."""
    app, other = await stage.application(), await stage.application()
    await app.send(json.dumps(CONNECT).encode())
    try:
        message = await app.hear()
        expect("the id of the answer", message.get("id"), "c")
        stage.remark("binary frames are read as text, as by the reference engine; ours closes with 1003")
    except Deviation:
        expect("the close code for a binary frame", (await app.closed())[0], 1003)
    await other.granted("rois.system.connect")


@CHECKS("frames-fragments")
async def _frames_fragments(stage: Stage) -> None:
    """A message in fragments is one message."""
    app = await stage.application()

    async def fragments() -> AsyncIterator[str]:
        text = json.dumps(CONNECT)
        for start in range(0, len(text), 7):
            yield text[start : start + 7]

    app.expect_answer_to("c")
    await app.socket.send(fragments())
    expect("the result", (await app.response("c")).get("result"), {"return_code": "OK"})


@CHECKS("size-long")
async def _size_long(stage: Stage) -> None:
    """A message of 32 KiB is accepted."""
    app = await stage.application()
    app.expect_answer_to("c")
    text = json.dumps(CONNECT)
    await app.send(text + " " * (_LONG - len(text)))
    expect("the result", (await app.response("c")).get("result"), {"return_code": "OK"})


@CHECKS("size-too-long")
async def _size_too_long(stage: Stage) -> None:
    """A message of 8 MiB closes its connection with 1009 and costs no other connection anything."""
    app, other = await stage.application(), await stage.application()
    with suppress(Deviation, ConnectionClosed):
        await app.send(" " * _TOO_LONG)
    # A client that is cut off while still sending may not get to read the close frame.
    expect("the close code", (await app.closed())[0], 1009, 1006)
    await other.granted("rois.system.connect")


@CHECKS("ping")
async def _ping(stage: Stage) -> None:
    """A ping is answered."""
    app = await stage.application()
    try:
        async with asyncio.timeout(stage.patience):
            await (await app.socket.ping())
    except TimeoutError:
        raise Deviation("a pong", "nothing") from None


@CHECKS("size-adapter-profile", Needs.ADAPTER)
async def _size_adapter_profile(stage: Stage) -> None:
    """The profile of an adapter with all seventeen types is accepted, although it is longer than 32 KiB."""
    app = await stage.application()
    size = len(json.dumps(await app.granted("rois.system.get_profile")))
    if size < _LONG:
        raise Deviation(f"a profile of more than {_LONG} bytes", f"{size} bytes")


@CHECKS("many-requests")
async def _many_requests(stage: Stage) -> None:
    """Two hundred requests at once are each answered once."""
    app = await stage.application()
    asked = [await app.begin("rois.system.connect") for _ in range(200)]
    for request_id in asked:
        expect("the result", await app.result("rois.system.connect", request_id), {"return_code": "OK"})
    await app.silent("every request has had its answer")


@CHECKS("origin-foreign")
async def _origin_foreign(stage: Stage) -> None:
    """A web page of another site is refused, or the gateway admits every client."""
    try:
        await stage.application(additional_headers={"Origin": "https://evil.example"})
    except Deviation as deviation:
        if "403" not in deviation.came:
            raise
        return
    stage.remark(
        "pages of other sites are let in: a person that opens one lets it operate every robot that can be reached"
    )
