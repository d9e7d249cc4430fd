"""The libraries of the media plane and the codecs that they bring. Needs `openrois[streaming]`."""

import platform
from importlib.metadata import PackageNotFoundError, version
from typing import Final

from openrois_streaming.aiortc_internals.trial import UnsupportedLibrary, self_test
from openrois_streaming.codecs import H264, LIBRARIES, OPUS, VP8, available_codecs

from openrois_demo.doctor.finding import Finding, Level

__all__ = ["codecs", "libraries"]

_LIBRARIES: Final = ("aiortc", "aioice", "av")


async def libraries() -> Finding:
    """Check that the media plane can use the installed versions of its libraries."""
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
    """Return the codecs that can be encoded here."""
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
