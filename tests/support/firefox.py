"""A real Firefox without a window, driven over WebDriver BiDi (https://w3c.github.io/webdriver-bidi/)."""

import asyncio
import itertools
import json
import os
import re
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any, Final

from websockets.asyncio.client import ClientConnection, connect

__all__ = ["PATIENCE", "FirefoxTab", "firefox_at"]

PATIENCE: Final = 60.0
"""Seconds that Firefox and the page may take for anything; on an idle machine a start takes about three."""

_PREFERENCES: Final = {
    "app.update.enabled": False,
    "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False,
    "media.autoplay.default": 0,
    "media.gmp-manager.updateEnabled": False,
    "media.navigator.permission.disabled": True,
    "media.navigator.streams.fake": True,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "toolkit.telemetry.enabled": False,
}
"""No dialog, no connection to anything but the page, and devices of Firefox's own instead of real ones."""

_PROBE: Final = Path(__file__).parents[1] / "e2e" / "probe.js"
_ENDPOINT: Final = re.compile(r"WebDriver BiDi listening on (ws://\S+)")


class FirefoxTab:
    """One tab, over the connection that drives its browser.

    Args:
        connection: to the browser's WebDriver BiDi end; at most one call is under way at a time.
    """

    def __init__(self, connection: ClientConnection) -> None:
        self.complaints: list[str] = []
        """What the page logged as an error, and its exceptions."""
        self._connection = connection
        self._numbers = itertools.count(1)
        self._context = ""

    async def open(self, url: str) -> None:
        """Begin a session and load a page in a new tab."""
        await self._call("session.new", capabilities={})
        await self._call("session.subscribe", events=["log.entryAdded"])
        await self._call("script.addPreloadScript", functionDeclaration=f"() => {{ {_PROBE.read_text()} }}")
        self._context = (await self._call("browsingContext.create", type="tab"))["context"]
        await self._call("browsingContext.setViewport", context=self._context, viewport={"width": 1280, "height": 900})
        await self._call("browsingContext.navigate", context=self._context, url=url, wait="complete")

    async def read(self, expression: str) -> Any:
        """Return what a JavaScript expression gives, awaited; objects have to be made text by it.

        Raises:
            AssertionError: it threw.
        """
        answer = await self._call(
            "script.evaluate",
            expression=f"({expression})",
            target={"context": self._context},
            awaitPromise=True,
            userActivation=True,
        )
        assert answer["type"] == "success", answer.get("exceptionDetails", {}).get("text", answer)
        return answer["result"].get("value")

    async def until(self, condition: str) -> Any:
        """Return what a JavaScript expression gives, awaited, as soon as that is true."""
        return await self.read(
            f"""new Promise((resolve, reject) => {{
                const end = performance.now() + {PATIENCE * 1000};
                const look = async () => {{
                    const found = await ({condition});
                    if (found) resolve(found);
                    else if (performance.now() > end) reject(new Error("not so in time"));
                    else setTimeout(() => look().catch(reject), 25);
                }};
                look().catch(reject);
            }})"""
        )

    async def click(self, test_id: str, within: str = "") -> None:
        """Click the middle of an element, or of what is found within it, with the mouse, once it can be clicked."""
        element = f"document.querySelector('[data-testid={test_id}] {within}')"
        await self.until(f"{element} && !{element}.disabled && {element}.checkVisibility()")
        await self.read(f"{element}.scrollIntoView({{ block: 'center' }})")
        place = json.loads(
            await self.read(
                f"(({{ x, y, width, height }}) => JSON.stringify([x + width / 2, y + height / 2]))"
                f"({element}.getBoundingClientRect())"
            )
        )
        x, y = (round(each) for each in place)
        move = {"type": "pointerMove", "x": x, "y": y}
        presses = [{"type": kind, "button": 0} for kind in ("pointerDown", "pointerUp")]
        await self._perform({"type": "pointer", "id": "mouse", "actions": [move, *presses]})

    async def type(self, text: str) -> None:
        """Press and release the keys of a text; Enter is `\\ue007`."""
        presses = [{"type": kind, "value": key} for key in text for kind in ("keyDown", "keyUp")]
        await self._perform({"type": "key", "id": "keyboard", "actions": presses})

    async def key_down(self, key: str) -> None:
        """Press a key and hold it."""
        await self._perform({"type": "key", "id": "keyboard", "actions": [{"type": "keyDown", "value": key}]})

    async def key_up(self, key: str) -> None:
        """Release a key."""
        await self._perform({"type": "key", "id": "keyboard", "actions": [{"type": "keyUp", "value": key}]})

    async def screenshot(self) -> str:
        """Return what the tab shows, as the Base64 text of a PNG file."""
        answer = await self._call("browsingContext.captureScreenshot", context=self._context)
        return str(answer["data"])

    async def _perform(self, actions: dict[str, Any]) -> None:
        await self._call("input.performActions", context=self._context, actions=[actions])

    async def _call(self, method: str, **params: Any) -> dict[str, Any]:
        """Call a method of WebDriver BiDi; events that come before its answer are taken note of.

        Raises:
            AssertionError: the browser answers with an error.
        """
        number = next(self._numbers)
        await self._connection.send(json.dumps({"id": number, "method": method, "params": params}))
        async with asyncio.timeout(2 * PATIENCE):
            while True:
                message = json.loads(await self._connection.recv())
                if message["type"] == "event":
                    self._note(message["params"])
                elif message.get("id") == number:
                    assert message["type"] == "success", f"{method}: {message.get('message')}"
                    result: dict[str, Any] = message["result"]
                    return result

    def _note(self, entry: dict[str, Any]) -> None:
        if entry.get("level") == "error":
            self.complaints.append(str(entry.get("text")))


@asynccontextmanager
async def firefox_at(program: Path, profile: Path, url: str) -> AsyncIterator[FirefoxTab]:
    """Run Firefox with a new profile for as long as the block lasts, and open a page in it.

    Args:
        program: Firefox.
        profile: an empty folder.
        url: the page.
    """
    lines = (f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in _PREFERENCES.items())
    (profile / "user.js").write_text("".join(lines))
    process = await asyncio.create_subprocess_exec(
        *(str(program), "--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", "0"),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.PIPE,
        env={**os.environ, "MOZ_CRASHREPORTER_DISABLE": "1", "HOME": str(profile)},
        start_new_session=True,
    )
    draining: asyncio.Task[None] | None = None
    try:
        async with asyncio.timeout(PATIENCE):
            endpoint = await _endpoint(process)
        draining = asyncio.create_task(_drain(process))
        async with connect(f"{endpoint}/session", max_size=None, ping_interval=None) as connection:
            tab = FirefoxTab(connection)
            await tab.open(url)
            yield tab
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
        if draining is not None:
            await draining


async def _endpoint(process: asyncio.subprocess.Process) -> str:
    """Return the address at which a starting browser can be driven."""
    assert process.stderr is not None
    while line := (await process.stderr.readline()).decode(errors="replace"):
        if found := _ENDPOINT.search(line):
            return found[1]
    raise AssertionError("Firefox has ended before it could be driven")


async def _drain(process: asyncio.subprocess.Process) -> None:
    """Read what the browser writes, so that it never waits for a reader."""
    assert process.stderr is not None
    while await process.stderr.read(65536):
        pass
