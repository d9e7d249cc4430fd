"""Server-sent events, as they arrive. Pure."""

from typing import Final

__all__ = ["MAX_EVENT", "EventReader", "MalformedEvents"]

MAX_EVENT: Final = 262_144
"""Bytes of one event."""


class MalformedEvents(ValueError):
    """What came is no stream of events; the text says why."""


class EventReader:
    """Reads the data of events; their names and ids are of no use here."""

    def __init__(self) -> None:
        self._rest = b""
        self._data: list[str] = []
        self._size = 0

    def add(self, data: bytes) -> list[str]:
        """Return the data of the events that are complete with more bytes.

        Raises:
            MalformedEvents: an event is too long, or is no text.
        """
        # A line ends with CR LF, LF or CR; a CR at the end may be half of a CR LF.
        held = b"\r" if data.endswith(b"\r") else b""
        text = (self._rest + data.removesuffix(held)).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        *lines, rest = text.split(b"\n")
        self._rest = rest + held
        events = [event for line in lines if (event := self._add_line(line)) is not None]
        if self._size + len(self._rest) > MAX_EVENT:
            raise MalformedEvents(f"an event has more than {MAX_EVENT} bytes")
        return events

    def _add_line(self, line: bytes) -> str | None:
        """Return the data of the event that an empty line ends."""
        if not line:
            event, self._data, self._size = "\n".join(self._data), [], 0
            return event or None
        name, _, value = line.partition(b":")
        if name == b"data":
            self._size += len(line)
            if self._size > MAX_EVENT:
                raise MalformedEvents(f"an event has more than {MAX_EVENT} bytes")
            try:
                self._data.append(value.removeprefix(b" ").decode())
            except UnicodeDecodeError:
                raise MalformedEvents("an event is no text in UTF-8") from None
        return None
