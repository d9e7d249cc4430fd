"""What can go wrong between an application and its gateway; what goes wrong in RoIS terms is in `openrois.errors`."""

__all__ = ["ConnectionFailed", "ConnectionLost"]


class ConnectionFailed(ConnectionError):
    """No connection came about; the message says at which address and why.

    Attributes:
        final: whether trying again cannot help, because the gateway does not let this application in.
    """

    def __init__(self, message: str, *, final: bool = False) -> None:
        super().__init__(message)
        self.final = final


class ConnectionLost(ConnectionError):
    """There is no connection now, or it ended before the answer came: whether it was done is not known."""
