"""A visit to the page: a real Chromium, its tab, and what is seen, heard and received there."""

import asyncio
import itertools
import json
import re
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from playwright.async_api import Browser, ConsoleMessage, Error, Locator, Page, WebSocket, async_playwright, expect

__all__ = ["GATEWAY_AWAY", "PATIENCE", "Seen", "Visit", "running_browser", "visiting"]

Message = dict[str, Any]
T = TypeVar("T")

PATIENCE: Final = 30.0
"""Seconds that anything here may take; on an idle machine nearly all of it takes less than one."""

GATEWAY_AWAY: Final = r"WebSocket connection to .* failed|Failed to load resource: net::ERR_"
"""What Chromium itself writes to the console for each attempt to reach a gateway that is away."""

expect.set_options(timeout=PATIENCE * 1000)  # a slow machine is no fault of the page

_BANNER: Final = "document.querySelector('[data-testid=banner]:not([hidden])')"
_PROBE: Final = Path(__file__).parents[1] / "e2e" / "probe.js"
_ARGUMENTS: Final = (
    "--no-sandbox",  # tests may run as root
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
)


@dataclass(frozen=True, slots=True)
class Seen:
    """What the stage looked like at a moment: mean and spread of its luma, without the badges at its edges."""

    luma: float
    spread: float

    @property
    def black(self) -> bool:
        """Whether no picture is visible: the placeholder is darker and flatter than the colour bars."""
        return self.luma < 60 or self.spread < 25


@dataclass
class Visit:
    """One tab.

    Attributes:
        page: it.
        tolerated: what the console may say, as patterns.
        complaints: what the console said beyond that: errors, warnings, exceptions.
        sent: the messages that the page sent over its WebSocket.
        received: those that it received.
    """

    page: Page
    tolerated: Sequence[str] = ()
    complaints: list[str] = field(default_factory=list)
    sent: list[Message] = field(default_factory=list)
    received: list[Message] = field(default_factory=list)
    _passing: asyncio.Event = field(default_factory=asyncio.Event)

    def item(self, name: str) -> Locator:
        """Return the element with this test id."""
        return self.page.get_by_test_id(name)

    async def press(self, name: str) -> None:
        """Click a button as soon as it can be clicked."""
        await self.item(name).click(timeout=PATIENCE * 1000)

    async def until(self, condition: str) -> Any:
        """Return what a JavaScript expression gives as soon as that is true.

        Playwright's own `wait_for_function` evaluates text in the page, which the page's security policy forbids.
        """
        return await self.page.evaluate(f"probe.until(() => ({condition}), {PATIENCE * 1000})")

    async def read(self, expression: str) -> Any:
        """Return the present value of a JavaScript expression."""
        return await self.page.evaluate(f"({expression})")

    async def status(self, kind: str, status: str) -> None:
        """Wait until the page shows this status of its video or audio."""
        shown = self.item(f"status-{kind}")
        await expect(shown).to_have_attribute("data-status", f"STREAMING_{status}", timeout=PATIENCE * 1000)

    async def banner(self, kind: str, title: str) -> str:
        """Wait for the banner of this kind, whose title has these words; returns all it says."""
        words = str(await self.until(f"{_BANNER}?.dataset.kind === '{kind}' && {_BANNER}.innerText"))
        assert title in words
        return words

    async def no_banner(self) -> None:
        """Wait until the page shows no banner."""
        await expect(self.item("banner")).to_be_hidden(timeout=PATIENCE * 1000)

    async def plays(self, count: int = 5) -> list[dict[str, float]]:
        """Wait for so many more pictures and return them: their stamps, mean luma, and when they were presented."""
        presented = await self.read("probe.presented")
        frames: list[dict[str, float]] = await self.until(
            f"probe.presented >= {presented + count} && probe.frames.slice(-{count})"
        )
        return frames

    async def longest_gap(self) -> float:
        """The longest time between two of the pictures so far, in milliseconds."""
        moments = [frame["at"] for frame in await self.read("probe.frames")]
        return float(max(later - earlier for earlier, later in itertools.pairwise(moments)))

    async def stream_id(self, kind: str) -> str:
        """Wait until the page has a stream of this kind, and return its id."""
        return str(await self.until(f"openrois.{kind}?.streamId"))

    async def another_stream(self, kind: str, than: str) -> str:
        """Wait until the page has a stream with another id, and return that."""
        stream_id = f"openrois.{kind}?.streamId"
        return str(await self.until(f"{stream_id} !== '{than}' && {stream_id}"))

    def told(self, method: str, **params: str) -> list[Message]:
        """The params of the notifications of a method that were received so far, if they have these members."""
        found = [message["params"] for message in self.received if message.get("method") == method]
        return [each for each in found if params.items() <= each.items()]

    async def until_told(self, method: str, **params: str) -> Message:
        """Wait for such a notification; only the wire is looked at."""
        return (await self._until_passed(lambda: self.told(method, **params)))[-1]

    async def until_sent(self, method: str, fits: Callable[[Message], bool]) -> Message:
        """Wait until the page has sent a request of a method whose params fit, and return them."""

        def found() -> list[Message]:
            return [each["params"] for each in self.sent if each["method"] == method and fits(each["params"])]

        return (await self._until_passed(found))[-1]

    def executed(self, component_ref: str, command_type: str) -> list[str]:
        """The ids of the commands of this type that the page executed on a component so far."""
        return [
            unit["command_id"]
            for message in self.sent
            if message["method"] == "rois.command.execute"
            for unit in message["params"]["command_unit_list"]
            if (unit["component_ref"], unit["command_type"]) == (component_ref, command_type)
        ]

    async def until_executed(self, component_ref: str, command_type: str, beyond: int = 0) -> str:
        """Wait for such a command, after the first `beyond` ones, and return the id of the last one."""
        return (await self._until_passed(lambda: self.executed(component_ref, command_type)[beyond:]))[-1]

    async def _until_passed(self, found: Callable[[], list[T]]) -> list[T]:
        """Wait until there is something among the messages that the page sent or received."""
        async with asyncio.timeout(PATIENCE):
            while not (there := found()):
                self._passing.clear()
                await self._passing.wait()
        return there

    async def watch(self, name: str, left: float, top: float, width: float, height: float) -> None:
        """Watch a part of the picture from now on; places and sizes are fractions of the picture's."""
        await self.page.evaluate(f"probe.watch('{name}', {left}, {top}, {width}, {height})")

    async def seen(self, name: str) -> list[dict[str, float]]:
        """What `watch` has seen: how much each frame differed from the one before (`step`) and the first (`away`)."""
        samples: list[dict[str, float]] = await self.read(f"probe.watched.{name}")
        return samples

    async def listen(self) -> None:
        """Touch the page, so that it may sound, and listen from then on."""
        await self.page.get_by_role("heading", name="OpenRoIS").click()
        await self.page.evaluate("probe.listen()")

    async def look(self) -> Seen:
        """Return what the stage shows, read from a screenshot."""
        picture = await self.picture()
        height, width = picture.shape
        middle = picture[height // 5 : height * 3 // 4, width // 8 : width * 7 // 8]
        return Seen(float(middle.mean()), float(middle.std()))

    async def shows(self) -> None:
        """Wait until the stage shows a picture."""
        async with asyncio.timeout(PATIENCE):
            while (await self.look()).black:
                pass

    async def picture(self) -> NDArray[np.uint8]:
        """The luma of the stage, out of a screenshot."""
        stage = self.item("stage")
        before, after = None, await stage.bounding_box()
        while before is None or before != after:  # a banner that came or went has moved the stage meanwhile
            before = after
            png = await self.page.screenshot(clip=before)
            after = await stage.bounding_box()
        grey = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_GRAYSCALE)
        assert grey is not None
        return np.asarray(grey, np.uint8)

    @asynccontextmanager
    async def watched(self) -> AsyncIterator[list[Seen]]:
        """Look again and again for as long as the block lasts, and once at least; yields what was seen so far."""
        seen: list[Seen] = []
        ended = asyncio.Event()

        async def watch() -> None:
            while not (seen and ended.is_set()):
                seen.append(await self.look())

        watching = asyncio.create_task(watch())
        try:
            yield seen
            ended.set()
            await watching
        finally:
            watching.cancel()
            with suppress(asyncio.CancelledError):
                await watching

    def connected(self, socket: WebSocket) -> None:
        """Record the messages of a WebSocket of the page."""
        socket.on("framesent", lambda text: self._passed(text, self.sent))
        socket.on("framereceived", lambda text: self._passed(text, self.received))

    def _passed(self, text: str | bytes, messages: list[Message]) -> None:
        messages.append(json.loads(text))
        self._passing.set()

    def heard(self, message: ConsoleMessage) -> None:
        """Take a message of the console."""
        if message.type in ("error", "warning"):
            self.complain(f"{message.type}: {message.text}")

    def complain(self, text: str) -> None:
        """Take a complaint, unless it is tolerated."""
        if not any(re.search(pattern, text) for pattern in self.tolerated):
            self.complaints.append(text)


@asynccontextmanager
async def running_browser(program: Path, *arguments: str) -> AsyncIterator[Browser]:
    """Run a browser without a window for as long as the block lasts."""
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=program, args=[*_ARGUMENTS, *arguments])
        try:
            yield browser
        finally:
            await browser.close()


@asynccontextmanager
async def visiting(
    browser: Browser, url: str, *, tolerated: Sequence[str] = (), script: str = "", **options: Any
) -> AsyncIterator[Visit]:
    """Open the page in a context of its own; afterwards its console must have been silent.

    Args:
        browser: runs it.
        url: of the gateway.
        tolerated: what the console may say, as patterns.
        script: runs in the page before its own scripts.
        options: of the context, such as `viewport` or `color_scheme`.
    """
    context = await browser.new_context(**{"viewport": {"width": 1280, "height": 800}, **options})
    try:
        page = await context.new_page()
        visit = Visit(page, tolerated)
        page.on("websocket", visit.connected)
        page.on("console", visit.heard)
        page.on("pageerror", lambda error: visit.complain(f"exception: {error}"))
        await page.add_init_script(path=_PROBE)
        if script:
            await page.add_init_script(script)
        await page.goto(url)
        yield visit
        with suppress(Error):  # the tab may have been closed
            visit.complaints += await visit.read("probe.violations")
        assert not visit.complaints, visit.complaints
    finally:
        await context.close()
