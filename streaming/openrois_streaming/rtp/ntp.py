"""Time formats of RTP: 64 bits of NTP, their middle, and 24 bits of sending time. Pure."""

_TO_1900 = 2_208_988_800  # seconds from 1900, where NTP begins, to 1970


def ntp(moment: float) -> int:
    """Return `moment` (epoch seconds) in 64 bits (RFC 3550 section 4)."""
    return round((moment + _TO_1900) * 2**32) & (2**64 - 1)


def capture_time(moment: float) -> bytes:
    """Return `moment` (epoch seconds) as the eight bytes of abs-capture-time."""
    return ntp(moment).to_bytes(8, "big")


def middle(timestamp: int) -> int:
    """Return the middle 32 bits of an NTP timestamp, which identify a report (RFC 3550 section 6.4.1)."""
    return timestamp >> 16 & 0xFFFFFFFF


def abs_send_time(moment: float) -> bytes:
    """Return `moment` (epoch seconds) as three bytes of seconds modulo 64, 18 bits of them fraction."""
    return (int(moment * 2**18) & 0xFFFFFF).to_bytes(3, "big")
