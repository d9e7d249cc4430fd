"""Formats of a log record: one line whatever is in it, for people or as JSON, and without secrets. Pure."""

import json
import logging
import re
from collections.abc import Iterable
from datetime import UTC, datetime
from typing import Final

from openrois.observability.correlation import correlation

__all__ = ["HIDDEN", "JsonLine", "Redaction", "TextLine"]

HIDDEN: Final = "[hidden]"
"""What stands for a secret."""

LONGEST: Final = 16_384
"""Characters of a message or a traceback; the middle of a longer one is left out."""

_SECRETS: Final = (
    # Each behind texts of which one is part of whatever matches: searching those is ten times as fast.
    # JSON Web Tokens; what follows a scheme of authorization or a name of a secret; what media negotiation is made of.
    (("eyJ",), re.compile(r"()\beyJ[A-Za-z0-9_-]{5,}\.[A-Za-z0-9_-]+(?:\.[A-Za-z0-9_-]*)?")),
    (("earer", "EARER"), re.compile(r"(\b[Bb](?:earer|EARER)[ .])[A-Za-z0-9._~+/=-]{8,}")),
    (("token=",), re.compile(r"([?&](?:access_)?token=)[^&\s\"']+")),
    (
        ("credential", "token", "secret", "password"),
        re.compile(r"([\"'](?:credential|(?:\w+_)?token|secret|password)[\"']: ?[\"'])[^\"']+"),
    ),
    (("v=0",), re.compile(r"()v=0(?:\r\n|\\r\\n|\n|\\n)o=.*", re.DOTALL)),
    (("a=ice-", "a=fingerprint:"), re.compile(r"()a=(?:ice-pwd|ice-ufrag|fingerprint):[^\\\r\n\"]+")),
)


_HINTS: Final = tuple((hint, pattern) for hints, pattern in _SECRETS for hint in hints)


class Redaction:
    """Removes secrets from text: the last net, for none should be logged.

    Args:
        secrets: texts that are secret whatever they look like; short ones are no secrets.
    """

    def __init__(self, secrets: Iterable[str] = ()) -> None:
        self._known = sorted((secret for secret in secrets if len(secret) >= 8), key=len, reverse=True)

    def __call__(self, text: str) -> str:
        """Return the text without them."""
        for secret in self._known:
            text = text.replace(secret, HIDDEN)
        for hint, pattern in _HINTS:
            if hint in text:
                text = pattern.sub(rf"\1{HIDDEN}", text)
        return text


class _Line(logging.Formatter):
    def __init__(self, redact: Redaction) -> None:
        super().__init__()
        self._redact = redact

    def _message(self, record: logging.LogRecord) -> str:
        try:
            message = record.getMessage()
        except Exception as error:
            # A wrong call of a logger is worth a line, and no traceback of the logging module's own.
            message = f"{record.msg!r} cannot be written: {error}"
        return _cut(self._redact(message))

    def _traceback(self, record: logging.LogRecord) -> str:
        parts = [self.formatException(record.exc_info)] if record.exc_info else []
        if record.stack_info:
            parts.append(record.stack_info)
        return _cut(self._redact("\n".join(parts)))


class TextLine(_Line):
    """For people: `time level logger: [correlation] message | traceback`."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the record as one line."""
        told = self._redact(correlation())
        line = f"{_time(record)} {record.levelname[0]} {record.name}: {f'[{told}] ' if told else ''}"
        text = _printable(line + self._message(record))
        trace = self._traceback(record)
        return f"{text} | {' | '.join(_printable(part) for part in trace.splitlines())}" if trace else text


class JsonLine(_Line):
    """For machines: an object with `time`, `level`, `logger`, `message`, and perhaps `correlation` and `exception`."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the record as one line."""
        told = {
            "time": _time(record),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": self._message(record),
            "correlation": self._redact(correlation()),
            "exception": self._traceback(record),
        }
        line = json.dumps({name: text for name, text in told.items() if text or name == "message"})
        # Of what is ASCII and no character it leaves this one as it is.
        return line.replace("\x7f", "\\u007f")


def _time(record: logging.LogRecord) -> str:
    return datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _cut(text: str) -> str:
    if len(text) <= LONGEST:
        return text
    return f"{text[: LONGEST // 2]} … {text[-LONGEST // 2 :]}"


def _printable(text: str) -> str:
    """Return the text with everything escaped that could end the line, move the cursor or turn the direction."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
