"""What a session refuses, and why. Each message is a sentence for a person and holds no SDP and no address."""


class SessionError(Exception):
    """A session cannot do what it was asked."""


class UnknownStream(SessionError):
    """There is no such stream in this session."""


class UnknownPeer(SessionError):
    """There is no such peer connection in this session, or it has ended."""


class StaleGeneration(SessionError):
    """A candidate belongs to another generation than the present one; it was dropped."""


class UnexpectedAnswer(SessionError):
    """No offer waits for the answer; it was dropped."""


class InvalidDescription(SessionError):
    """An answer cannot be used."""


class InvalidCandidate(SessionError):
    """A candidate cannot be read."""


class TooManyCandidates(SessionError):
    """The peer sent as many candidates as it may; this one was dropped."""


class NoCommonCodec(SessionError):
    """The application can decode none of the codecs that can be offered."""


class NoEncoder(SessionError):
    """The engine encodes as much as it may, and nothing of it in a codec of the application."""


class TooManySections(SessionError):
    """All m-sections of the peer connection are in use."""


class TooManySessions(SessionError):
    """No further application can be served."""


class PeerClosed(SessionError):
    """The other end has closed the peer connection, which is told in a moment."""


class NoPath(SessionError):
    """There is no way for media to leave this machine that the settings allow."""
