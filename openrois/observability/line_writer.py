"""Lines to a file that may be rotated, written by a thread: the caller never waits for the disk."""

import logging
import os
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Final, Generic, Self, TypeVar

__all__ = ["LineWriter"]

_log = logging.getLogger(__name__)

RECORDS_LIMIT: Final = 65_536
"""Records that wait to be written; one more is lost and counted."""

_BATCH: Final = 1024
_GATHERING: Final = 0.02
_RETRY: Final = 1.0
_JOIN: Final = 5.0

RecordT = TypeVar("RecordT")


class LineWriter(Generic[RecordT]):
    """A thread that appends records to a file, while the block that it is entered for runs.

    The file is made with mode 0600. One that was renamed or removed (log rotation) is made again with the next record.
    A disk that is full or gone is tried again every second; what does not fit in the queue meanwhile is lost, and a
    line of its own says how much.

    Args:
        path: the file, to which is appended.
        render: writes a record as one line without its end; called in the thread.
        gap: writes the line that stands where records were lost, given how many.
        limit: records that may wait.

    Attributes:
        lost: how many records found no room.
        written: how many records are in the file.
        failures: how often the file could not be written.
        failing: the last attempt to write failed.
    """

    def __init__(
        self, path: Path, render: Callable[[RecordT], str], gap: Callable[[int], str], limit: int = RECORDS_LIMIT
    ) -> None:
        self._path = path
        self._render = render
        self._gap = gap
        self._limit = limit
        self._queue: deque[RecordT] = deque()
        self._wake = threading.Event()
        self._stopping = threading.Event()
        self._file = -1
        self._unwritten = b""
        self._told = 0
        self.lost = 0
        self.written = 0
        self.failures = 0
        self.failing = False
        self._thread = threading.Thread(target=self._run, name=f"writes {path.name}", daemon=True)

    def __enter__(self) -> Self:
        """Open the file and start.

        Raises:
            OSError: it cannot be written.
        """
        self._open()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write what waits, for at most some seconds."""
        self._stopping.set()
        self._wake.set()
        self._thread.join(_JOIN)

    def __len__(self) -> int:
        return len(self._queue)

    @property
    def is_running(self) -> bool:
        """Whether the thread runs."""
        return self._thread.is_alive()

    @property
    def limit(self) -> int:
        """Number of records that may wait."""
        return self._limit

    def put(self, record: RecordT, *, dispensable: bool = False) -> bool:
        """Queue a record; False if too many wait already, and it is lost.

        Args:
            record: what to write.
            dispensable: it may use half of the queue only.
        """
        if len(self._queue) >= (self._limit // 2 if dispensable else self._limit):
            self.lost += 1
            return False
        self._queue.append(record)
        if not self._wake.is_set():
            self._wake.set()
        return True

    def _run(self) -> None:
        while not self._stopping.is_set():
            self._wake.wait()
            self._wake.clear()
            while self._work():
                # What comes soon goes with the next batch: a thread that wakes for each record costs more than it.
                if self._stopping.wait(_RETRY if self.failing else _GATHERING):
                    break
        while self._work() and not self.failing:
            pass
        if self._file >= 0:
            os.close(self._file)

    def _work(self) -> bool:
        """Write one batch; tell whether there is more to do."""
        if not self._unwritten:
            self._unwritten = self._batch()
        if not self._unwritten:
            return False
        try:
            self._reopen_if_rotated()
            while self._unwritten:
                self._unwritten = self._unwritten[os.write(self._file, self._unwritten) :]
        except OSError as error:
            self.failures += 1
            if not self.failing:
                _log.error("%s cannot be written: %s", self._path, error.strerror or error)
            self.failing = True
        else:
            if self.failing:
                _log.info("%s is written again", self._path)
            self.failing = False
        return True

    def _batch(self) -> bytes:
        lines: list[str] = []
        while self._queue and len(lines) < _BATCH:
            lines.append(self._render(self._queue.popleft()))
        self.written += len(lines)
        if not self._queue and (lost := self.lost) > self._told:
            lines.append(self._gap(lost - self._told))
            self._told = lost
        return "".join(f"{line}\n" for line in lines).encode("utf-8", "backslashreplace")

    def _open(self) -> None:
        self._file = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)

    def _reopen_if_rotated(self) -> None:
        opened = os.fstat(self._file) if self._file >= 0 else None
        try:
            there = self._path.stat()
        except FileNotFoundError:
            there = None
        if opened is None or there is None or not os.path.samestat(opened, there):
            if self._file >= 0:
                os.close(self._file)
                self._file = -1
            self._open()
