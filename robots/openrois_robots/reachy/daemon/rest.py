"""Requests to the daemon: each has a deadline, and fails in a sentence."""

import asyncio
import errno
import json
import socket
from collections.abc import Awaitable, Callable
from types import TracebackType
from typing import Any, Final, Self

import aiohttp

from openrois.adapter import ComponentFailed
from openrois_robots.reachy.daemon.address import REMEDY, Address

__all__ = ["DEADLINE", "Daemon", "DaemonSilent", "DaemonUnreachable", "unreachable", "within"]

DEADLINE: Final = 1.0
"""Seconds that a request may take. The daemon answers within milliseconds."""

_UPLOAD: Final = 30.0
"""Seconds that a sound may take to it, of some megabytes over a slow network."""
_LARGEST: Final = 1 << 20
"""Bytes of an answer."""
_REASONS: Final = {
    errno.ECONNREFUSED: "nothing listens at this port",
    errno.EHOSTUNREACH: "there is no way to it in the network",
    errno.ENETUNREACH: "there is no way to it in the network",
    errno.ECONNRESET: "it has closed the connection",
    errno.EPIPE: "it has closed the connection",
}
_UNTRUSTED: Final = "Untrusted Host header"


class DaemonUnreachable(ComponentFailed):
    """There is no connection to the daemon, or it broke."""


class DaemonSilent(ComponentFailed):
    """The daemon has not answered in time."""


class Daemon:
    """The REST API of one daemon; `async with` it.

    Args:
        address: of the daemon.

    Attributes:
        session: of all connections to it.
    """

    session: aiohttp.ClientSession

    def __init__(self, address: Address) -> None:
        self.address = address

    async def __aenter__(self) -> Self:
        # The robot is in the same network, whatever proxy the environment names.
        self.session = aiohttp.ClientSession(self.address.url("http"), trust_env=False)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.session.close()

    async def get(self, path: str) -> Any:
        """Return the answer to a query.

        Raises:
            DaemonUnreachable: there is no connection to the daemon, or what listens there is none.
            DaemonSilent: it has not answered in time.
            ComponentFailed: it refused; the sentence has its reason.
        """
        return await self._request("GET", path, DEADLINE)

    async def get_object(self, path: str) -> dict[str, Any]:
        """Return the answer to a query that is answered with an object; raises as `get`."""
        told = await self.get(path)
        if not isinstance(told, dict):
            raise _foreign()
        return told

    async def post(self, path: str, body: Any = None) -> Any:
        """Return the answer to a command; raises as `get`."""
        return await self._request("POST", path, DEADLINE, json=body)

    async def delete(self, path: str) -> Any:
        """Return the answer to a removal; raises as `get`."""
        return await self._request("DELETE", path, DEADLINE)

    async def upload_sound(self, name: str, sound: bytes) -> None:
        """Put a sound (a WAV file) where the daemon finds it by its name; raises as `get`."""
        form = aiohttp.FormData()
        form.add_field("file", sound, filename=name, content_type="audio/wav")
        await self._request("POST", "/api/media/sounds/upload", _UPLOAD, data=form)

    async def _request(self, method: str, path: str, deadline: float, **content: Any) -> Any:
        async def exchange() -> tuple[int, bytes]:
            async with self.session.request(method, path, **content) as response:
                return response.status, await response.content.read(_LARGEST)

        status, body = await within(deadline, f"{method} {path}", exchange)
        return _answer(f"{method} {path}", status, body)


async def within(deadline: float, what: str, exchange: Callable[[], Awaitable[Any]]) -> Any:
    """Return what an exchange with the daemon returns.

    Args:
        deadline: seconds that it may take.
        what: is exchanged, for the sentence.
        exchange: does it.

    Raises:
        DaemonUnreachable: there is no connection to the daemon, or what listens there is none.
        DaemonSilent: it took longer.
    """
    try:
        async with asyncio.timeout(deadline):
            return await exchange()
    except TimeoutError:
        raise DaemonSilent(f"{what} was not answered within {deadline:g} s") from None
    except OSError as error:
        raise DaemonUnreachable(unreachable(error)) from None
    except aiohttp.ServerDisconnectedError:
        raise DaemonUnreachable(f"it has closed the connection; {REMEDY}") from None
    except (aiohttp.ClientError, ValueError):
        raise _foreign() from None


def _answer(what: str, status: int, body: bytes) -> Any:
    try:
        told = json.loads(body)
    except ValueError:
        if status < 500:
            raise _foreign() from None
        told = {}
    if status < 400:
        return told
    detail = told.get("detail") if isinstance(told, dict) else None
    if detail == _UNTRUSTED:
        raise DaemonUnreachable("its daemon takes an IP address or a name that ends in .local only; change --robot")
    if status == 404 and detail == "Not Found":
        raise _foreign()
    raise ComponentFailed(f"{what} failed: {detail if isinstance(detail, str) else f'status {status}'}")


def _foreign() -> DaemonUnreachable:
    return DaemonUnreachable(f"what listens there is no daemon of a Reachy Mini, or one that is too old; {REMEDY}")


def unreachable(error: OSError) -> str:
    """Return why a daemon cannot be reached and what to do, from what a connection has raised."""
    # What aiohttp raises has the error of the system as `os_error`.
    cause = getattr(error, "os_error", error)
    if isinstance(cause, socket.gaierror):
        return f"this name is not known in the network; {REMEDY}"
    reason = _REASONS.get(cause.errno or 0, str(cause) or "it has closed the connection")
    return f"{reason}; {REMEDY}"
