"""Errors between an application and its gateway; errors in RoIS terms are in `openrois.errors`."""

__all__ = ["ConnectionFailed", "ConnectionLost"]


class ConnectionFailed(ConnectionError):
    """No connection could be made; the message has the address and the cause.

    Attributes:
        final: whether trying again cannot help, because the gateway does not let this application in.
    """

    def __init__(self, message: str, *, final: bool = False) -> None:
        super().__init__(message)
        self.final = final


class ConnectionLost(ConnectionError):
    """There is no connection, or it ended before the answer came: whether the request was carried out is unknown."""
