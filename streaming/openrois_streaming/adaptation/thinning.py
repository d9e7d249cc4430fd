"""Which pictures of a source are left when there are to be fewer a second. Pure."""


class Thinning:
    """Chooses `frame_rate` pictures a second, as evenly as the source's pace allows."""

    __slots__ = ("_due", "_interval")

    def __init__(self, frame_rate: float) -> None:
        self._interval = 1 / frame_rate
        self._due = float("-inf")

    def wants(self, captured_at: float) -> bool:
        """Whether the picture of this moment (seconds) is one of them."""
        # A camera is never exactly in time: what comes a little early is the one that was meant.
        if captured_at < self._due - self._interval / 4:
            return False
        self._due += self._interval
        if self._due <= captured_at:
            self._due = captured_at + self._interval
        return True
