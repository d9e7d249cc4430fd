"""The issuer's JSON Web Key Set in a cache: keys by `kid`, fetched rarely and never by what a token says."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

import aiohttp

from openrois.aio.tasks import TaskScope
from openrois.auth.key_files import read_key_file
from openrois.auth.keys import MAX_KEY_FILE, KeysUnavailable, VerificationKey, parse_key_set
from openrois.auth.loopback import is_loopback

__all__ = ["Fetch", "KeySetCache", "fetch_from_file", "fetch_from_url", "flaw_of_address"]

_log = logging.getLogger(__name__)

REFETCH_PAUSE: Final = 30.0
"""Seconds between two attempts to fetch the keys, whatever the tokens ask for."""

FRESH: Final = 300.0
"""Seconds for which fetched keys are used without checking whether they have changed."""

KEPT: Final = 3600.0
"""Seconds for which fetched keys are used while the issuer cannot be reached."""

FETCH_TIMEOUT: Final = 5.0

Fetch = Callable[[], Awaitable[str]]
"""Gets the text of the key set; raises `ValueError` with a sentence where there is none."""


class KeySetCache:
    """Keys by their ids, fetched when they are needed; requests that come together share one fetch.

    Args:
        fetch: gets the key set.
        clock: monotonic seconds.
        tasks: owns the fetch, which goes on when the request that caused it is gone.
    """

    def __init__(self, fetch: Fetch, clock: Callable[[], float], tasks: TaskScope) -> None:
        self._fetch = fetch
        self._clock = clock
        self._tasks = tasks
        self._keys: Mapping[str, VerificationKey] = {}
        self._fetched = self._tried = float("-inf")
        self._fetching: asyncio.Task[None] | None = None
        self.fetches = 0
        self.failures = 0

    async def find(self, key_id: str) -> tuple[VerificationKey, ...]:
        """Return the key with that id; nothing where the issuer has none. Only a look-up: an id is never an address.

        Raises:
            KeysUnavailable: the issuer cannot be reached, and there are no keys from the last hour.
        """
        key = self._usable().get(key_id)
        if key is None or self._clock() - self._fetched >= FRESH:
            self._begin()
        if key is None and self._fetching is not None:
            # A client with a known key does not wait for the issuer.
            await asyncio.wait({self._fetching})
            key = self._usable().get(key_id)
        if key is not None:
            return (key,)
        if not self._usable():
            raise KeysUnavailable
        return ()

    def is_usable(self) -> bool:
        """Tell whether there are keys; where there are none they are fetched, unless that was just tried."""
        if not self._usable():
            self._begin()
        return bool(self._usable())

    def _usable(self) -> Mapping[str, VerificationKey]:
        return self._keys if self._clock() - self._fetched < KEPT else {}

    def _begin(self) -> None:
        if self._fetching is None and self._clock() - self._tried >= REFETCH_PAUSE:
            self._tried = self._clock()
            self.fetches += 1
            self._fetching = self._tasks.start(self._refresh())

    async def _refresh(self) -> None:
        try:
            self._keys = parse_key_set(await self._fetch())
            self._fetched = self._clock()
        except ValueError as error:
            self.failures += 1
            _log.warning("the issuer's keys: %s", error)
        finally:
            self._fetching = None


def flaw_of_address(url: str) -> str:
    """Return why `url` cannot be an address of keys; empty where it can."""
    try:
        parts = urlsplit(url)
        host = parts.hostname or ""
    except ValueError:
        return "it is no address"
    if parts.scheme == "http" and not is_loopback(host):
        return "http can be changed on its way: give an https address, except for this machine"
    if parts.scheme not in ("http", "https") or not host:
        return "it is no https address, such as https://issuer.example.org/jwks.json"
    return "it carries a password" if parts.username is not None else ""


def fetch_from_url(url: str) -> Fetch:
    """Return a function that fetches the key set from an address: no redirects, 5 s, 256 KiB.

    Raises:
        ValueError: `url` is no address that keys may come from.
    """
    if flaw := flaw_of_address(url):
        raise ValueError(f"{url[:200]!r} cannot be the address of the issuer's keys: {flaw}")

    async def fetch() -> str:
        timeout = aiohttp.ClientTimeout(total=FETCH_TIMEOUT)
        try:
            async with (
                # What is packed could be any size once it is unpacked.
                aiohttp.ClientSession(timeout=timeout, auto_decompress=False) as session,
                session.get(url, allow_redirects=False) as response,
            ):
                if response.status != 200:
                    raise ValueError(f"{url} answered {response.status}")
                content = bytearray()
                async for part in response.content.iter_chunked(16 << 10):
                    content += part
                    if len(content) > MAX_KEY_FILE:
                        raise ValueError(f"{url} answered more than {MAX_KEY_FILE} bytes")
                return content.decode()
        except TimeoutError:
            raise ValueError(f"{url} did not answer within {FETCH_TIMEOUT:g} s") from None
        except (aiohttp.ClientError, OSError, UnicodeDecodeError) as error:
            raise ValueError(f"{url} cannot be fetched: {error}") from None

    return fetch


def fetch_from_file(path: Path) -> Fetch:
    """Return a function that reads the key set from a file."""

    async def fetch() -> str:
        return read_key_file(path)

    return fetch
