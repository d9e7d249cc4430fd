"""STOP: a component's own `stop`, and the end of its commands with ABORT, whether or not it answers in time."""

import asyncio
import logging
from collections.abc import Iterable
from typing import Final

from openrois.accepted import AcceptedCommands
from openrois.engine import Engine
from openrois.errors import RoISError

__all__ = ["STOP_TIMEOUT", "stop_components"]

_log = logging.getLogger(__name__)

STOP_TIMEOUT: Final = 1.0
"""Seconds that a component has to say that it has stopped; its commands end with ABORT then in any case."""


async def stop_components(
    engine: Engine, accepted: AcceptedCommands, component_refs: Iterable[str], reason: str
) -> dict[str, str]:
    """Stop components side by side.

    Args:
        engine: where they are.
        accepted: the commands that may run on them.
        component_refs: the components; what has no command `stop` has only its commands ended.
        reason: a sentence for whoever sent those commands.

    Returns:
        Why a component did not say that it has stopped, by its reference; empty text where it did.
    """
    chosen = tuple(component_refs)
    outcomes = await asyncio.gather(*(_stop(engine, accepted, ref, reason) for ref in chosen))
    return dict(zip(chosen, outcomes, strict=True))


async def _stop(engine: Engine, accepted: AcceptedCommands, component_ref: str, reason: str) -> str:
    failure = ""
    for command in accepted.of(component_ref):
        command.stopping = reason
    profile = engine.directory.component_profiles.get(component_ref)
    try:
        if profile is not None and profile.command("stop") is not None:
            async with asyncio.timeout(STOP_TIMEOUT):
                await engine.invoke(component_ref, "stop")
    except TimeoutError:
        failure = f"no answer within {STOP_TIMEOUT:g} s"
    except RoISError as error:
        failure = str(error)
    finally:
        for command in accepted.of(component_ref):
            command.abort(reason)
    if failure:
        _log.warning("%s did not confirm that it has stopped: %s", component_ref, failure)
    return failure
