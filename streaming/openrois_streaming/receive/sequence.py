"""Numbers of a few bits that wrap around, made into ones that only grow. Pure."""


class Unwrapped:
    """Follows a counter of `bits` bits, as RTP's sequence numbers and timestamps are (RFC 3550 section 5.1)."""

    __slots__ = ("_modulus", "_newest")

    def __init__(self, bits: int) -> None:
        self._modulus = 1 << bits
        self._newest: int | None = None

    def __call__(self, value: int) -> int:
        """`value` without its wraps: of all numbers that end like it, the one nearest to the newest so far."""
        number = self.nearest(value)
        if self._newest is None or number > self._newest:
            self._newest = number
        return number

    def nearest(self, value: int) -> int:
        """The same, for a value that says nothing of where the counter is."""
        if self._newest is None:
            # Far enough from 0 that what came before stays positive.
            return self._modulus + value
        distance = (value - self._newest) % self._modulus
        return self._newest + distance - (self._modulus if distance >= self._modulus // 2 else 0)
