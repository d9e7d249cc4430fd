"""What is given as a source, judged before a viewer waits for it. Pure."""

import inspect
from collections.abc import AsyncIterator, Iterator
from os import PathLike
from typing import Any, Final

__all__ = ["CAMERA_REMEDY", "check_function", "is_source", "source_remedy"]

CAMERA_REMEDY: Final = "use opencv_camera, v4l2_camera or ffmpeg_input for the number, path or URL of a camera"
"""What to do with the number, path or URL of a camera."""


def is_source(given: object) -> bool:
    """Tell whether `given` is a `MediaSource`, as far as that can be seen without opening it.

    Its `open` takes no arguments; that of a path, a capture of OpenCV or a class is something else.
    """
    opening = getattr(given, "open", None)
    others = isinstance(given, type | PathLike) or _is_capture(given)
    return callable(opening) and not others and _needs_nothing(opening)


def check_function(given: object, name: str, remedy: str) -> None:
    """Check that `given` is a function without arguments, such as a generator function.

    Args:
        given: what should be one.
        name: of the source, for the error.
        remedy: what to do with the number, path or URL of a device.

    Raises:
        TypeError: it is none; the text says what to give in its place.
    """
    wrong = f"{name} must be a function that returns an iterator, not"
    if _is_capture(given):
        raise TypeError(f"{wrong} {_kind(given)}: {source_remedy(given)}")
    if isinstance(given, str | bytes | int | float | PathLike):
        raise TypeError(f"{wrong} {given!r}: {remedy}")
    if isinstance(given, Iterator | AsyncIterator):
        raise TypeError(f"{wrong} {_kind(given)}: do not call it")
    if not callable(given) or (isinstance(given, type) and callable(getattr(given, "open", None))):
        raise TypeError(f"{wrong} {_kind(given)}: give a generator function")
    if not _needs_nothing(given):
        raise TypeError(f"{wrong} one that needs arguments: bind them, as in `lambda: pictures(camera)`")


def source_remedy(given: object) -> str:
    """Return what to do with `given`, which is no source."""
    if _is_capture(given):
        return "use opencv_camera(0), which opens and releases the capture itself"
    if isinstance(given, str | int | PathLike):
        return CAMERA_REMEDY
    return "wrap it in VideoSource, EncodedSource or AudioSource"


def _is_capture(given: object) -> bool:
    """Tell whether `given` is a capture, as `cv2.VideoCapture` is, or its class; OpenCV need not be here."""
    return all(callable(getattr(given, method, None)) for method in ("isOpened", "read", "release"))


def _kind(given: object) -> str:
    return f"the class {given.__name__}" if isinstance(given, type) else f"a {type(given).__name__}"


def _needs_nothing(function: Any) -> bool:
    """Tell whether `function` can be called without arguments; one of a compiled library need not say that."""
    try:
        inspect.signature(function).bind()
    except TypeError:
        return False
    except ValueError:
        return True
    return True
