"""A journal in an SQLite file: records are written by a thread, and commands wait for that only briefly."""

import asyncio
import logging
import sqlite3
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from openrois.journal.file import JournalFile
from openrois.journal.former import FormerCommand, FormerCommands
from openrois.journal.journal import MAX_WAITING, PATIENCE
from openrois.journal.records import Accepted, Ended, Presence, Record, Told
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

__all__ = ["SqliteJournal"]

_log = logging.getLogger(__name__)

_BATCH: Final = 1024
_RETRY: Final = 1.0
_JOIN: Final = 5.0


class SqliteJournal(AbstractContextManager["SqliteJournal"]):
    """A `Journal` in a file. Enter it within the event loop.

    A command is in the file before it is accepted, as long as the disk does its part: what a client was told is not
    forgotten when the process ends. A disk that is slow, full or gone stops no command; what it does not take is
    counted, logged once, and tried again every second.

    Args:
        path: the file.
        clock: epoch seconds.
        open_file: opens the file.

    Attributes:
        lost: records that found no room.
        failures: how often the file could not be written.
        failing: whether the last attempt failed.
        written: records in the file.
        late: commands that were accepted before they were in the file.
        engines: those that were there when the last run of the gateway ended.

    Raises:
        JournalUnusable: on entering: the file is something else, or another gateway's.
    """

    def __init__(
        self,
        path: Path,
        *,
        clock: Callable[[], float] = time.time,
        open_file: Callable[[Path], JournalFile] = JournalFile,
    ) -> None:
        self.lost = 0
        self.failures = 0
        self.failing = False
        self.written = 0
        self.late = 0
        self.engines: frozenset[str] = frozenset()
        self._path = path
        self._clock = clock
        self._open_file = open_file
        self._former = FormerCommands()
        self._queue: deque[tuple[Record, asyncio.Future[None] | None]] = deque()
        self._wake = threading.Event()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)

    def __enter__(self) -> Self:
        self._file = self._open_file(self._path)
        self._former = self._file.former
        self.engines = self._file.engines
        self._loop = asyncio.get_running_loop()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write what waits, for at most some seconds."""
        self._stopping.set()
        self._wake.set()
        self._thread.join(_JOIN)

    @property
    def waiting(self) -> int:
        """Number of records that wait to be written."""
        return len(self._queue)

    async def accepted(self, session: str, subject: str, commands: Mapping[str, str]) -> None:
        """Note commands that are about to be accepted; returns when they are in the file, or a moment later."""
        at, last = self._clock(), None
        if not self.failing:
            last = self._loop.create_future()
        left = len(commands)
        for command_id, component_ref in commands.items():
            left -= 1
            self._put(Accepted(session, command_id, subject, component_ref, at), None if left else last)
        if last is not None:
            done, _ = await asyncio.wait((last,), timeout=PATIENCE)
            if not done:
                self.late += 1

    def ended(
        self, session: str, command_id: str, status: CompletedStatus, reason: str, results: tuple[Result, ...]
    ) -> None:
        """Note that a command has ended."""
        self._put(Ended(session, command_id, status, reason, results))

    def engine(self, engine_id: str, *, is_there: bool) -> None:
        """Note that an engine was attached or detached."""
        self._put(Presence(engine_id, is_there))

    async def find(self, subject: str, command_id: str) -> FormerCommand | None:
        """Return a command of a former run of the gateway."""
        return self._former.find(subject, command_id)

    async def deliver_outcome(self, subject: str, command_id: str) -> FormerCommand | None:
        """Return a command of a former run whose end was not notified yet, and note that it is from now on."""
        command = self._former.find(subject, command_id)
        if command is None or command.is_notified:
            return None
        command.is_notified = True
        self._put(Told(subject, command_id))
        return command

    def _put(self, record: Record, done: asyncio.Future[None] | None = None) -> None:
        if len(self._queue) >= MAX_WAITING:
            self.lost += 1
            if done is not None:
                done.set_result(None)
            return
        self._queue.append((record, done))
        if not self._wake.is_set():
            self._wake.set()

    def _run(self) -> None:
        while not self._stopping.is_set():
            self._wake.wait()
            self._wake.clear()
            while self._queue:
                if not self._write(self._file) and self._stopping.wait(_RETRY):
                    break
        while self._queue and self._write(self._file):
            pass
        self._file.close()

    def _write(self, file: JournalFile) -> bool:
        """Write one batch; tell whether that worked."""
        batch = [self._queue[index] for index in range(min(len(self._queue), _BATCH))]
        try:
            file.write(record for record, _ in batch)
        except sqlite3.Error as error:
            self.failures += 1
            if not self.failing:
                _log.error("the journal %s cannot be written: %s; commands go on without it", file.path, error)
            self.failing = True
        else:
            self.written += len(batch)
            if self.failing:
                _log.info("the journal %s is written again", file.path)
            self.failing = False
            for _ in batch:
                self._queue.popleft()
        waiting = [done for _, done in batch if done is not None]
        if waiting:
            with suppress(RuntimeError):
                # The loop may be over by now.
                self._loop.call_soon_threadsafe(_settle, waiting)
        return not self.failing


def _settle(waiting: list[asyncio.Future[None]]) -> None:
    for done in waiting:
        if not done.done():
            done.set_result(None)
