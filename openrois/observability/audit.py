"""The audit trail: sign-ins, refusals and actions as JSON lines, written without delaying anything."""

import json
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from json.encoder import encode_basestring_ascii
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from openrois.auth.principal import Principal
from openrois.errors import ComponentFailed
from openrois.observability.correlation import correlation
from openrois.observability.line_writer import RECORDS_LIMIT, LineWriter
from openrois.observability.log_lines import Redaction

__all__ = ["Audit"]

_LONGEST: Final = 300
"""Characters of one value in a record; a refused client may have chosen them."""


_quoted: Final[Callable[[str], str]] = encode_basestring_ascii

_NO_SECRETS: Final = Redaction()

_Record = tuple[float, str, str, str, str, str, str, str]


class Audit(AbstractContextManager["Audit"]):
    """Destination of the records: a file, or none.

    A call takes a microsecond or two and never waits: a thread writes. Refusals and sign-ins, which others can cause at
    will, may fill half of the queue only, so that they do not crowd out what was done. What is lost is counted, here
    and in the file. **Commands and STOP go on when it cannot be written; operations of administrators do not**: they
    call `require` first.

    Args:
        path: the file; None for nowhere.
        clock: epoch seconds.
        limit: records that may wait.
        redact: takes secrets out of what others wrote into a record.
    """

    def __init__(
        self,
        path: Path | None = None,
        *,
        clock: Callable[[], float] = time.time,
        limit: int = RECORDS_LIMIT,
        redact: Callable[[str], str] = _NO_SECRETS,
    ) -> None:
        self._clock = clock
        self._redact = redact
        self._writer = None if path is None else LineWriter[_Record](path, self._line, self._gap, limit)
        self.refusals = 0
        self.actions = 0

    def __enter__(self) -> Self:
        """Open the file.

        Raises:
            OSError: it cannot be written.
        """
        if self._writer is not None:
            self._writer.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._writer is not None:
            self._writer.__exit__(kind, error, trace)

    @property
    def waiting(self) -> int:
        """Number of records that wait to be written."""
        return 0 if self._writer is None else len(self._writer)

    @property
    def lost(self) -> int:
        """Number of records that were lost because too many waited."""
        return 0 if self._writer is None else self._writer.lost

    @property
    def failures(self) -> int:
        """Number of times the file could not be written."""
        return 0 if self._writer is None else self._writer.failures

    @property
    def is_kept(self) -> bool:
        """Whether what is recorded now will be in the file; also True where no file is configured."""
        writer = self._writer
        return writer is None or (not writer.failing and len(writer) < writer.limit)

    def require(self) -> None:
        """Refuse an operation that must not happen without a record.

        Raises:
            ComponentFailed: the trail cannot be written now.
        """
        if not self.is_kept:
            raise ComponentFailed(
                "the audit trail cannot be written, and without it an administrator's operation is refused"
            )

    def refused(self, principal: Principal | None, method: str, subject: str, reason: str) -> None:
        """Record that something was not allowed or not possible.

        Args:
            principal: of the client; None where it has none.
            method: what was called.
            subject: the component, command or stream that it was about.
            reason: why not; no secret.
        """
        self.refusals += 1
        self._put("refused", principal, method, subject, reason)

    def acted(self, principal: Principal | None, method: str, subject: str, detail: str = "") -> None:
        """Record that something was done or begun that changes what a robot does, or the permission for that.

        Args:
            principal: of the client.
            method: what was called.
            subject: the component, command or stream that it was about.
            detail: what else matters, such as the kind of the command and its id; no secret.
        """
        self.actions += 1
        self._put("acted", principal, method, subject, detail)

    def signed(self, principal: Principal, path: str, detail: str) -> None:
        """Record that a connection has signed in or out.

        Args:
            principal: of the client.
            path: what for: `/` for an application, `/adapter` for an adapter.
            detail: with which roles and from where it came, or how it ended.
        """
        self._put("session", principal, "session", path, detail)

    def _put(self, kind: str, principal: Principal | None, method: str, subject: str, detail: str) -> None:
        if self._writer is None:
            return
        who, token = ("", "") if principal is None else (principal.subject, principal.token_id)
        record = (self._clock(), kind, who, token, method, subject, detail, correlation())
        self._writer.put(record, dispensable=kind != "acted")

    def _line(self, record: _Record) -> str:
        at, kind, who, token, method, subject, detail, correlation = record
        told = {
            "kind": kind,
            "who": who,
            "method": method,
            "subject": subject,
            "reason" if kind == "refused" else "detail": detail,
            "token_id": token,
            "correlation": correlation,
        }
        whole = "\n".join(told.values())
        if len(whole) > _LONGEST or self._redact(whole) != whole:
            told = {name: self._fit(text) for name, text in told.items()}
        # Characters beyond ASCII and controls are escaped: one record is one line, whatever its values hold.
        written = [f'"{name}": {_quoted(text)}' for name, text in told.items() if text]
        return f'{{"time": {at:.6f}, {", ".join(written)}}}'.replace("\x7f", "\\u007f")

    def _fit(self, text: str) -> str:
        text = self._redact(text)
        return text if len(text) <= _LONGEST else text[:_LONGEST] + "…"

    def _gap(self, lost: int) -> str:
        return json.dumps({"time": self._clock(), "kind": "lost", "count": lost})
