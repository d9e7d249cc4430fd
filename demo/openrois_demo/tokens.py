"""Tokens that a demo issues: to its own adapters, and to programs of this user, which find theirs in files."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, Self

from openrois.auth.claims import MAX_LIFETIME
from openrois.auth.issuing import issue_token
from openrois.auth.key_files import make_key_files
from openrois.auth.principal import Role

__all__ = ["PROGRAMS", "DemoTokens"]

PROGRAMS: Final = ("agent", "script")
"""Ranks below that of people: there is a token for a program of each, whose name is that of its rank."""

_TTL: Final = int(MAX_LIFETIME)
"""Lifetime of each token in seconds."""

_RENEWAL: Final = 1200.0
"""Seconds between two tokens of one file, well within the lifetime of one."""

_OF_PROGRAMS: Final = (Role.OPERATOR, Role.VISITOR, Role.LISTENER)
"""Roles of a program: all that a visitor of the page has."""


class DemoTokens:
    """Tokens in files that this user alone can read, each good for an hour and written anew long before.

    Args:
        key: signs them.
        folder: gets the files.
        engine_ids: of the adapters that need one.

    Attributes:
        key: signs them.
        folder: has the files; this user alone can reach it.
        adapters: the file of each adapter.
        programs: the file of a program of each rank in `PROGRAMS`.
    """

    def __init__(self, key: Path, folder: Path, engine_ids: Iterable[str]) -> None:
        self.key = key
        self.folder = folder
        self.adapters = {engine_id: folder / f"{engine_id}.token" for engine_id in engine_ids}
        self.programs = {rank: folder / f"{rank}.token" for rank in PROGRAMS}
        self._write()

    @classmethod
    @contextmanager
    def issued(cls, key: Path | None, engine_ids: Iterable[str]) -> Iterator[Self]:
        """Issue tokens, whose files are there while the block runs.

        Args:
            key: signs them; None for one that is made for this demo, whose adapters need no tokens.
            engine_ids: of the adapters.

        Raises:
            ValueError: the key cannot be used.
        """
        with TemporaryDirectory(prefix="openrois-demo-") as name:
            folder = Path(name)
            if key is None:
                (made,) = make_key_files(folder / "key", "HS256")
                yield cls(made, folder, ())
            else:
                yield cls(key, folder, engine_ids)

    def viewer(self) -> str:
        """Return a new token for a program that only looks.

        Raises:
            ValueError: the key cannot be used.
        """
        return self._token("demo-viewer", (Role.VIEWER,), "*")

    async def keep(self, sleep: Callable[[float], Awaitable[None]] = asyncio.sleep) -> None:
        """Write new tokens into the files until cancelled, each long before the last one expires."""
        while True:
            await sleep(_RENEWAL)
            self._write()

    def _write(self) -> None:
        for engine_id, path in self.adapters.items():
            # It may offer the components of this engine and no others.
            _put(path, self._token(f"demo-{engine_id}", (Role.ADAPTER,), f"{engine_id}/*"))
        for rank, path in self.programs.items():
            _put(path, self._token(rank, _OF_PROGRAMS, "*", rank))

    def _token(self, subject: str, roles: tuple[Role, ...], scope: str, rank: str = "") -> str:
        return issue_token(self.key, subject, roles, [scope], now=int(time.time()), ttl=_TTL, rank=rank)


def _put(path: Path, token: str) -> None:
    """Put a token into a file, in which a reader always finds a whole one."""
    new = path.with_name(f"{path.name}.new")
    new.touch(0o600)
    new.write_text(f"{token}\n", encoding="ascii")
    new.replace(path)
