"""Requests to a server with an API like OpenAI's: each wait and each answer is bounded, and a failure is a sentence."""

from __future__ import annotations

import asyncio
import errno
import json
import socket
import ssl
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self, TypeVar

from openrois.extras import MissingExtra, needing_extra
from openrois_body.services.address import ServiceAddress

__all__ = ["BEGIN_TIMEOUT", "CONNECT_TIMEOUT", "STALL_TIMEOUT", "Answer", "Server", "ServerFailed", "ServerRefused"]

CONNECT_TIMEOUT: Final = 5.0
"""Seconds for a connection to a server."""
BEGIN_TIMEOUT: Final = 25.0
"""Seconds until an answer begins: a server without a stream makes all of it before."""
STALL_TIMEOUT: Final = 10.0
"""Seconds between two parts of an answer."""
MAX_KEY: Final = 4096
"""Characters of a key."""
_PART: Final = 65_536
_MAX_ERROR: Final = 16_384
_MAX_REASON: Final = 300
_REASONS: Final = {
    errno.ECONNREFUSED: "nothing listens there",
    errno.EHOSTUNREACH: "there is no way to it in the network",
    errno.ENETUNREACH: "there is no way to it in the network",
    errno.ECONNRESET: "it has closed the connection",
    errno.EPIPE: "it has closed the connection",
}
_T = TypeVar("_T")


class ServerFailed(Exception):
    """A server cannot be reached, or does not do what it should; the text is a sentence for a person."""


class ServerRefused(ServerFailed):
    """The server has refused what was asked, and would refuse it again."""


class Answer:
    """An answer that is arriving.

    Attributes:
        kind: its media type, in lower case and without parameters; empty if it has none.
        parameters: of the media type.
    """

    def __init__(self, server: Server, response: Any) -> None:
        self.kind: str = response.headers.get("Content-Type", "").partition(";")[0].strip().lower()
        self.parameters: Mapping[str, str] = _parameters(response.headers.get("Content-Type", ""))
        self._server = server
        self._content = response.content

    async def parts(self, most: int, patience: float) -> AsyncGenerator[bytes]:
        """Yield the answer as it arrives.

        Args:
            most: bytes that it may have.
            patience: seconds that it may be waited for, in all.

        Raises:
            ServerFailed: it is longer, takes longer, stalls, or ends in its middle.
        """
        clock = asyncio.get_running_loop().time
        seconds = BEGIN_TIMEOUT
        while True:
            begun = clock()
            part = await self._server.within(
                seconds, "has stopped in the middle of its answer", self._content.read(_PART)
            )
            if not part:
                return
            seconds = STALL_TIMEOUT
            patience -= clock() - begun
            most -= len(part)
            if most < 0:
                raise ServerFailed(f"{self._server.name} sent more than was asked for, and was cut off")
            if patience <= 0:
                raise ServerFailed(f"{self._server.name} took too long for its answer")
            yield part

    async def text(self, most: int) -> str:
        """Return the whole of an answer; raises as `parts`."""
        whole = b"".join([part async for part in self.parts(most, BEGIN_TIMEOUT)])
        return whole.decode("utf-8", "replace")


class Server:
    """A server; `async with` it.

    Args:
        address: of the server.
        name: what it is called in sentences: `the speech server`.
        option: that names its address, for remedies: `--voice-url`.
        key_file: holds the key that it wants, and is read for each request; None: it wants none.
    """

    def __init__(self, address: ServiceAddress, name: str, option: str, key_file: Path | None) -> None:
        self.name = f"{name} at {address.origin}"
        self._address = address
        self._option = option
        self._key_file = key_file
        self._session: Any = None

    async def __aenter__(self) -> Self:
        try:
            with needing_extra("speech"):
                import aiohttp
        except MissingExtra as error:
            raise ServerFailed(str(error)) from None
        # No proxy and no .netrc: what is said and the key go to the address that was named, and nowhere else.
        timeout = aiohttp.ClientTimeout(total=None, sock_connect=CONNECT_TIMEOUT)
        connector = aiohttp.TCPConnector(ssl=ssl.create_default_context())
        self._session = aiohttp.ClientSession(
            connector=connector, trust_env=False, timeout=timeout, auto_decompress=False
        )
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        session, self._session = self._session, None
        if session is not None:
            await session.close()

    def post(self, path: str, fields: Mapping[str, Any]) -> AbstractAsyncContextManager[Answer]:
        """Ask for something; the answer arrives while the context lasts.

        Args:
            path: what is asked, as `audio/speech`.
            fields: of the JSON object that asks for it.

        Raises:
            ServerRefused: the server refused it (400 or 422); the sentence has its reason.
            ServerFailed: it cannot be reached, wants a key, has too much to do, or has failed.
        """
        return self._answered(path, json=dict(fields))

    def post_sound(self, path: str, fields: Mapping[str, str], sound: bytes) -> AbstractAsyncContextManager[Answer]:
        """Send a WAV file with the fields of a form, as `post` does."""
        import aiohttp

        form = aiohttp.FormData(fields)
        form.add_field("file", sound, filename="utterance.wav", content_type="audio/wav")
        return self._answered(path, data=form)

    @asynccontextmanager
    async def _answered(self, path: str, **content: Any) -> AsyncIterator[Answer]:
        async with self._request("POST", path, **content) as response:
            if response.status >= 300:
                raise self._failure(path, response.status, await self._error_text(response))
            if response.headers.get("Content-Encoding", "identity") != "identity":
                raise ServerFailed(f"{self.name} answers compressed, which it was not asked for")
            yield Answer(self, response)

    async def probe(self) -> None:
        """Ask whether the server is there, and takes the key.

        Raises:
            ServerFailed: it is away, or refuses the key. What else it answers, 404 too, shows that it is there.
        """
        async with self._request("GET", "models") as response:
            if response.status in {401, 403}:
                raise self._failure("models", response.status, "")

    async def within(self, seconds: float, failing: str, work: Awaitable[_T]) -> _T:
        """Return the result of a part of an exchange.

        Args:
            seconds: that it may take.
            failing: what the server then does, for the sentence.
            work: what is awaited.

        Raises:
            ServerFailed: it took longer, or the connection broke.
        """
        import aiohttp

        try:
            async with asyncio.timeout(seconds):
                return await work
        except TimeoutError:
            raise ServerFailed(f"{self.name} {failing}: nothing came for {seconds:g} s") from None
        except (OSError, aiohttp.ClientError, ValueError) as error:
            raise ServerFailed(f"{self.name} cannot be used: {_reason(error)}; check {self._option}") from None

    @asynccontextmanager
    async def _request(self, method: str, path: str, **content: Any) -> AsyncIterator[Any]:
        headers = {"Accept-Encoding": "identity", **self._authorization()}
        asked = self._session.request(
            method, self._address.url(path), headers=headers, allow_redirects=False, **content
        )
        response = await self.within(BEGIN_TIMEOUT, "does not answer", asked)
        try:
            yield response
        finally:
            # An answer that was not read to its end is not waited for.
            response.close()

    async def _error_text(self, response: Any) -> str:
        """Return what the server says about its refusal, if it does so as OpenAI's does."""
        text = await self.within(STALL_TIMEOUT, "has stopped", response.content.read(_MAX_ERROR))
        try:
            told = json.loads(text)
        except ValueError:
            return ""
        said = told.get("error", told) if isinstance(told, dict) else told
        said = said.get("message", said.get("detail", "")) if isinstance(said, dict) else said
        return " ".join(str(said).split())[:_MAX_REASON] if isinstance(said, str) else ""

    def _failure(self, path: str, status: int, said: str) -> ServerFailed:
        """Return the error for a status."""
        if status in {401, 403}:
            # What the server says to that may repeat the key.
            remedy = f"name the file of its key ({self._option.replace('url', 'key-file')})"
            if self._key_file is not None:
                remedy = f"check the key in {self._key_file}"
            return ServerFailed(f"{self.name} refuses access ({status}): {remedy}")
        because = f": {self.without_key(said)}" if said else ""
        if status in {400, 413, 415, 422}:
            return ServerRefused(f"{self.name} refuses this ({status}){because or ', and does not say why'}")
        if status == 429:
            return ServerFailed(f"{self.name} takes no more now (429){because or '; try again later'}")
        if status < 400:
            return ServerFailed(f"{self.name} sends requests elsewhere ({status}); check {self._option}")
        if status == 404:
            return ServerFailed(f"{self.name} has no {path} (404){because}; check {self._option}")
        return ServerFailed(f"{self.name} has failed ({status}){because}")

    def _authorization(self) -> Mapping[str, str]:
        return {} if self._key_file is None else {"Authorization": f"Bearer {read_key(self._key_file)}"}

    def without_key(self, text: str) -> str:
        """Return what the server says without the key, which it may repeat."""
        return text if self._key_file is None else text.replace(read_key(self._key_file), "(the key)")


def read_key(path: Path) -> str:
    """Return the key in a file: its first line.

    Raises:
        ServerFailed: it cannot be read, or is none; the sentence does not say what is in it.
    """
    try:
        with path.open("rb") as file:
            text = file.read(MAX_KEY + 2).decode("ascii", "replace")
    except OSError as error:
        raise ServerFailed(f"the key cannot be read from {path}: {error.strerror}") from None
    key = text.partition("\n")[0].strip()
    if not 0 < len(key) <= MAX_KEY or not key.isascii() or not key.isprintable() or " " in key:
        raise ServerFailed(f"there is no key in {path}: its first line has to be the key")
    return key


def _reason(error: Exception) -> str:
    # What aiohttp raises has the error of the system as one of these.
    cause = getattr(error, "certificate_error", getattr(error, "os_error", error))
    if isinstance(cause, ssl.SSLCertVerificationError):
        return f"its certificate is not trusted ({cause.verify_message})"
    if isinstance(cause, ssl.SSLError):
        return f"it does not speak TLS ({cause.reason or 'no handshake'})"
    if isinstance(cause, socket.gaierror):
        return "this name is not known in the network"
    if isinstance(cause, OSError):
        return _REASONS.get(cause.errno or 0, cause.strerror or "it has closed the connection")
    return "it closed the connection before the end of its answer, or does not speak HTTP"


def _parameters(kind: str) -> dict[str, str]:
    found = {}
    for part in kind.split(";")[1:]:
        name, _, value = part.partition("=")
        found[name.strip().lower()] = value.strip().strip('"')
    return found
