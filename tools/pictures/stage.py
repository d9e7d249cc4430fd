"""A demo with the 3D avatar and a lamp behind it, and Chromium in front: what the pictures are taken of."""

import os
import shutil
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Final

from playwright.async_api import Browser, Page, async_playwright

from tools.pictures.record import ROOT

__all__ = ["browser", "demo", "visit"]

WIDTH, HEIGHT = 1280, 800
PATIENCE: Final = 60_000
"""Milliseconds that anything on the page may take."""


@contextmanager
def demo() -> Iterator[str]:
    """Run the demo and the lamp of the tutorial while the block runs; yields the address of the page.

    Raises:
        RuntimeError: the demo has ended before it was ready.
    """
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = (sys.executable, "-m", "openrois.cli", "demo", "--port", str(port), "--engine", "panda3d")
    size = ("--size", "960x540")
    running = subprocess.Popen((*command, *size), stdout=subprocess.PIPE, text=True, cwd=ROOT)
    assert running.stdout is not None
    ready = next((line for line in running.stdout if line.startswith("ready ")), "")
    if not ready:
        raise RuntimeError("the demo ended before it was ready; what it said stands above")
    environment = {**os.environ, "OPENROIS_GATEWAY": f"ws://127.0.0.1:{port}/adapter"}
    lamp = subprocess.Popen((sys.executable, ROOT / "docs/examples/lamp_adapter.py"), env=environment)
    try:
        yield ready.split()[1]
    finally:
        lamp.terminate()
        running.terminate()
        lamp.wait()
        running.wait()


@asynccontextmanager
async def browser() -> AsyncIterator[Browser]:
    """Run Chromium while the block runs.

    Raises:
        FileNotFoundError: there is none on this machine.
    """
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        raise FileNotFoundError("Chromium is not installed: apt-get install chromium")
    async with async_playwright() as playwright:
        arguments = ["--no-sandbox", "--autoplay-policy=no-user-gesture-required"]
        running = await playwright.chromium.launch(executable_path=chromium, args=arguments)
        try:
            yield running
        finally:
            await running.close()


@asynccontextmanager
async def visit(running: Browser, url: str) -> AsyncIterator[Page]:
    """Open the page in a window of its own, and wait until the avatar is seen."""
    context = await running.new_context(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light")
    page = await context.new_page()
    page.set_default_timeout(PATIENCE)
    try:
        await page.goto(url)
        await page.locator("[data-testid=status-video][data-status=STREAMING_RUNNING]").wait_for()
        await page.locator("button.reaction:not([disabled])").first.wait_for()
        yield page
    finally:
        await context.close()
