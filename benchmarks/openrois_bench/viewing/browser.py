"""The viewer in Chromium: a page of the bench's own, in a browser that is started for it and without a window."""

import asyncio
import os
import tempfile
from asyncio.subprocess import DEVNULL, PIPE
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from importlib.resources import files
from typing import Any, Final
from urllib.parse import quote

from aiohttp import web
from openrois_body.processes.child import Output, child_process
from openrois_streaming.clock import SystemClock
from pydantic import BaseModel, TypeAdapter, ValidationError

from openrois_bench.errors import BenchFailed, within
from openrois_bench.viewing.observation import Order, Sightings

__all__ = ["chromium_version", "watch_in_chromium"]

_OPTIONS: Final = (
    "--headless=new",
    "--no-first-run",
    "--no-default-browser-check",
    "--disable-background-networking",
    "--disable-dev-shm-usage",
    "--autoplay-policy=no-user-gesture-required",
)
_LARGEST_RESULT: Final = 4 << 20
_VERSION_TIMEOUT: Final = 10.0


async def chromium_version(chromium: str) -> str:
    """The version that the browser at that path gives itself.

    Raises:
        BenchFailed: it cannot be started.
    """
    asked = await asyncio.create_subprocess_exec(
        chromium, "--version", stdin=DEVNULL, stdout=PIPE, stderr=DEVNULL, start_new_session=True
    )
    try:
        async with within(_VERSION_TIMEOUT, "the start of Chromium"):
            told, _ = await asked.communicate()
    finally:
        if asked.returncode is None:
            asked.kill()
    numbers = [word for word in told.decode(errors="replace").split() if word[:1].isdigit()]
    if not numbers:
        raise BenchFailed(f"{chromium} does not say which version it is")
    return numbers[0]


async def watch_in_chromium(chromium: str, order: Order, *, patience: float) -> Sightings:
    """Have the page do what is ordered.

    Args:
        chromium: path of the browser.
        order: what to do.
        patience: seconds that it may take, the start of the browser included.

    Raises:
        BenchFailed: it took longer, the browser ended, or the page could not do it.
    """
    seen: asyncio.Future[str] = asyncio.get_running_loop().create_future()
    output = Output("chromium", SystemClock())
    # The browser's last helper process may still write into the folder while it is removed.
    async with _page(seen) as address, AsyncExitStack() as stack:
        folder = tempfile.TemporaryDirectory(prefix="openrois-bench-", ignore_cleanup_errors=True)
        profile = stack.enter_context(folder)
        url = f"{address}?order={quote(order.model_dump_json())}"
        options = (*_OPTIONS, *(("--no-sandbox",) if os.geteuid() == 0 else ()), f"--user-data-dir={profile}")
        program = ("openrois_bench.processes.program", chromium, *options, url)
        async with child_process(*program, output=output) as process:
            ended = asyncio.ensure_future(process.wait())
            either: set[asyncio.Future[Any]] = {seen, ended}
            try:
                first, _ = await asyncio.wait(either, timeout=patience, return_when=asyncio.FIRST_COMPLETED)
            finally:
                ended.cancel()
    if not seen.done():
        reason = "ended" if first else f"showed nothing within {patience:.0f} s"
        raise BenchFailed(f"Chromium {reason}: {output.last_words}")
    return _sightings(seen.result())


class _Failure(BaseModel):
    """Message of the page when it could not carry out its order."""

    error: str


_POSTED: Final[TypeAdapter[Sightings | _Failure]] = TypeAdapter(Sightings | _Failure)


def _sightings(text: str) -> Sightings:
    try:
        posted = _POSTED.validate_json(text)
    except ValidationError as error:
        raise BenchFailed(f"the page in Chromium posted figures that cannot be read: {error}") from error
    if isinstance(posted, _Failure):
        raise BenchFailed(f"the page in Chromium: {posted.error}")
    return posted


@asynccontextmanager
async def _page(seen: asyncio.Future[str]) -> AsyncIterator[str]:
    """Serve the page on a port of its own; yields its address, and `seen` gets what it posts."""

    async def page(_request: web.Request) -> web.Response:
        return web.Response(text=files(__package__).joinpath("browser_page.html").read_text(), content_type="text/html")

    async def post(request: web.Request) -> web.Response:
        text = await request.text()
        if not seen.done():
            seen.set_result(text)
        return web.Response()

    app = web.Application(client_max_size=_LARGEST_RESULT)
    app.router.add_get("/", page)
    app.router.add_post("/seen", post)
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.5)
    await runner.setup()
    try:
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        yield f"http://127.0.0.1:{runner.addresses[0][1]}/"
    finally:
        await runner.cleanup()
