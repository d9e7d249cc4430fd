"""Refusals of a session. Each message is a sentence for a person and holds no SDP and no address."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Final

_LIBRARIES: Final = frozenset({"aioice", "aiortc", "av", "cv2", "ifaddr", "numpy", "pylibsrtp"})


@contextmanager
def needing_libraries() -> Iterator[None]:
    """Import what needs the libraries of the media plane in the block.

    Raises:
        ModuleNotFoundError: one is not installed; the text names the command that installs it. An import that fails for
            another reason raises what it has raised.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name not in _LIBRARIES or find_spec(error.name) is not None:
            raise
        sentence = f"{error.name} is not installed: run `pip install 'openrois[streaming]'`"
        raise ModuleNotFoundError(sentence, name=error.name) from None


class SessionError(Exception):
    """Base of all refusals of a session."""


class UnknownStream(SessionError):
    """Reference to a stream that this session does not have."""


class UnknownPeer(SessionError):
    """Reference to a peer connection that this session does not have, or that has ended."""


class StaleGeneration(SessionError):
    """Candidate of another generation than the present one; it was dropped."""


class UnexpectedAnswer(SessionError):
    """Answer without an offer that waits for it; it was dropped."""


class InvalidDescription(SessionError):
    """Answer that cannot be used."""


class InvalidCandidate(SessionError):
    """Candidate that cannot be read."""


class TooManyCandidates(SessionError):
    """Candidate beyond the limit of a peer connection; it was dropped."""


class NoCommonCodec(SessionError):
    """Application that can decode none of the codecs on offer."""


class NoEncoder(SessionError):
    """Lack of an encoder: all are in use, and none of them encodes a codec of the application."""


class TooManySections(SessionError):
    """Peer connection all of whose m-sections are in use."""


class TooManySessions(SessionError):
    """Application beyond the limit of those that are served."""


class PeerClosed(SessionError):
    """Peer connection that the other end has closed; its bye follows."""


class NoPath(SessionError):
    """Lack of a network path that the settings allow."""


def words_of(error: BaseException) -> str:
    """Return what an exception says; its type where it says nothing."""
    return str(error) or type(error).__name__
