"""The profiles of a running system, read over its wire."""

import asyncio
from collections.abc import Mapping
from typing import Any, Final

from pydantic import ValidationError
from websockets.exceptions import InvalidHandshake

from openrois.jsonrpc.session import CALL_TIMEOUT, RpcError, RpcSession, SessionClosed
from openrois.profiles.files import problem
from openrois.transport.address import gateway_url
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.transport.unreachable import unreachable
from openrois.transport.websocket import dial
from openrois.types.codes import ReturnCode
from openrois.types.messages import ProfileResult

__all__ = ["NoProfile", "ask_profiles"]

_NOTHING: Final[Mapping[str, Any]] = {}


class NoProfile(Exception):
    """The profiles cannot be read; the message is a sentence."""


async def ask_profiles(
    url: str, component_ref: str = "", *, credentials: Credentials = NO_CREDENTIALS, timeout: float = CALL_TIMEOUT
) -> ProfileResult:
    """Return the result of `get_profile` at `url`.

    Args:
        url: of a gateway, as `gateway_url` takes it.
        component_ref: the one component to ask for; empty for all.
        credentials: what is shown to the gateway.
        timeout: seconds to wait for each answer.

    Raises:
        NoProfile: there is no answer, or not that of an HRI engine, or it has no such component.
    """
    try:
        address = gateway_url(url)
    except ValueError as error:
        raise NoProfile(str(error)) from None
    condition = "component_ref = '" + component_ref.replace("'", "''") + "'" if component_ref else ""
    try:
        async with dial(address, credentials=credentials) as stream:
            session = RpcSession(stream, call_timeout=timeout)
            running = asyncio.ensure_future(session.run())
            try:
                await session.call("rois.system.connect", _NOTHING)
                answer = await session.call("rois.system.get_profile", {"condition": condition})
                await session.call("rois.system.disconnect", _NOTHING)
            finally:
                await session.close()
                await asyncio.wait({running})
    except TimeoutError:
        raise NoProfile(f"{url} does not answer in time") from None
    except (InvalidHandshake, ValueError, OSError) as error:
        said = unreachable(url, error, remedies=("--token-file", "--ca-file"))
        raise NoProfile(said) from None
    except (SessionClosed, RpcError) as error:
        raise NoProfile(f"what answers at {url} is no gateway: {error}") from None
    return _checked(url, component_ref, answer)


def _checked(url: str, component_ref: str, answer: object) -> ProfileResult:
    try:
        result = ProfileResult.model_validate(answer)
    except ValidationError as error:
        raise NoProfile(f"{url} answers with a malformed profile: {problem(error)}") from None
    if result.return_code is not ReturnCode.OK:
        raise NoProfile(f"{url} answers {result.return_code} and no profile")
    if component_ref and component_ref not in result.component_profiles:
        raise NoProfile(f"there is no component {component_ref!r} at {url}")
    return result
