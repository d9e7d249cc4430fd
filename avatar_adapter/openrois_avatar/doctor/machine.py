"""What this machine has: libraries, codecs, renderers, a voice, senses, a browser, a port, a clock, and time."""

import os
import platform
import socket
import time
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from openrois_streaming.aiortc_internals.trial import UnsupportedLibrary, self_test
from openrois_streaming.codecs import H264, LIBRARIES, OPUS, VP8, available_codecs

import openrois
from openrois_avatar.backends import Backend, chosen
from openrois_avatar.bench.browser import find_chromium
from openrois_avatar.doctor.finding import Finding, Level
from openrois_avatar.game_engines import NoGameEngine, choose_game_engine
from openrois_avatar.hearing.recognizer import RECOGNIZERS
from openrois_avatar.hearing.sphinx import Sphinx
from openrois_avatar.vision.backends import FINDERS, GESTURE_READERS
from openrois_avatar.vision.backends import RECOGNIZERS as FACE_RECOGNIZERS
from openrois_avatar.vision.cascades import CascadeFinder
from openrois_avatar.vision.head_reader import HeadReader
from openrois_avatar.vision.patterns import PatternRecognizer

__all__ = ["browser", "clock", "codecs", "game_engine", "hearing", "libraries", "load", "port", "vision", "voice"]

_LIBRARIES: Final = ("aiortc", "aioice", "av")


async def libraries() -> Finding:
    """The versions, and whether the media plane can use them."""
    told = ", ".join((f"Python {platform.python_version()}", *(f"{name} {_version(name)}" for name in _LIBRARIES)))
    try:
        await self_test()
    except UnsupportedLibrary as error:
        return Finding(
            Level.FAIL, "libraries", f"{told}: {error}", "Install OpenRoIS anew into an environment of its own."
        )
    return Finding(Level.OK, "libraries", told)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "(not installed)"


def codecs() -> Finding:
    """Which codecs can be encoded."""
    there = available_codecs()
    told = ", ".join(name.partition("/")[2] for name in there) or "none"
    missing = [f"{name.partition('/')[2]} ({library})" for name, library in LIBRARIES.items() if name not in there]
    if not missing:
        return Finding(Level.OK, "codecs", told)
    works = OPUS in there and (H264 in there or VP8 in there)
    return Finding(
        Level.WARN if works else Level.FAIL,
        "codecs",
        f"{told}; missing: {', '.join(missing)}",
        "Install PyAV as a wheel of PyPI, which contains them: pip install --force-reinstall --only-binary :all: av",
    )


def game_engine() -> Finding:
    """What would render the avatar."""
    try:
        name, missing = choose_game_engine("auto")
    except NoGameEngine as error:
        advice = "Install one with pip install openrois[demo]; --engine synthetic shows a test picture without."
        return Finding(Level.WARN, "renderer", str(error), advice)
    return Finding(Level.WARN if missing else Level.OK, "renderer", name, missing)


def voice() -> Finding:
    """Whether the avatar can speak."""
    if find_spec("espeakng_loader") is not None:
        return Finding(Level.OK, "voice", "espeak-ng")
    return Finding(Level.WARN, "voice", "no espeak-ng: the avatar is mute", "pip install openrois[speech]")


def hearing() -> Finding:
    """Whether the avatar can recognise speech, and what does."""
    return _sense("hearing", "the avatar recognises no speech", (chosen(RECOGNIZERS, Sphinx),))


def vision() -> Finding:
    """Whether the avatar can see who is before the camera, and what finds, recognises and reads them."""
    backends = (
        chosen(FINDERS, CascadeFinder),
        chosen(FACE_RECOGNIZERS, PatternRecognizer),
        chosen(GESTURE_READERS, HeadReader),
    )
    return _sense("vision", "the avatar sees no faces", backends)


def _sense(name: str, otherwise: str, backends: Sequence[Backend]) -> Finding:
    told = ", ".join(type(backend).__name__ for backend in backends)
    reasons = [reason for works, reason in (backend.available() for backend in backends) if not works]
    if not reasons:
        return Finding(Level.OK, name, told)
    return Finding(Level.WARN, name, f"{told}: {otherwise}", "; ".join(reasons))


def browser() -> Finding:
    """Whether there is a browser for the page."""
    found = find_chromium()
    if found is not None:
        return Finding(Level.OK, "browser", found)
    advice = "Any browser with WebRTC shows the page; `openrois bench latency` measures in Chromium or Chrome."
    return Finding(Level.WARN, "browser", "neither Chromium nor Chrome is found here", advice)


def port(number: int) -> Finding:
    """Whether the gateway's TCP port is free."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", number))
        except OSError as error:
            advice = "A gateway may be running there already; another one takes --port."
            return Finding(Level.WARN, "gateway's port", f"TCP {number} is taken ({error.strerror})", advice)
    return Finding(Level.OK, "gateway's port", f"TCP {number} is free")


def clock() -> Finding:
    """Whether the time of day can be right: credentials of TURN servers expire by it."""
    now, installed = time.time(), Path(openrois.__file__).stat().st_mtime
    told = time.strftime("%Y-%m-%d %H:%M:%S %Z", time.localtime(now))
    if now < installed:
        advice = "Set the clock (a time server does it for good): credentials of TURN servers expire by it."
        return Finding(Level.WARN, "clock", f"{told}, which is before OpenRoIS was installed here", advice)
    return Finding(Level.OK, "clock", told)


def load() -> Finding:
    """Whether the machine has time for encoders."""
    cores, busy = os.cpu_count() or 1, os.getloadavg()[0]
    told = f"load {busy:.1f} on {cores} cores"
    if busy < cores:
        return Finding(Level.OK, "load", told)
    return Finding(
        Level.WARN, "load", told, "What else runs here takes time from the encoders; pictures will come late."
    )
