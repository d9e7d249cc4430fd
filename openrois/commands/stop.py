"""STOP: a component's own `stop`, and the end of its commands with ABORT, whether or not it answers in time."""

import asyncio
import logging
from collections.abc import Iterable
from functools import partial
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.commands.pending import PendingCommands
from openrois.engine.engine import Engine
from openrois.errors import RoISError

__all__ = ["PAUSE", "STOP_TIMEOUT", "stop_components"]

_log = logging.getLogger(__name__)

STOP_TIMEOUT: Final = 1.0
"""Seconds that a component has to confirm its stop; its commands end with ABORT then in any case."""

PAUSE: Final = 0.05
"""Seconds after which a component that has not yet stopped gets another `stop`, for all requests made meanwhile."""


async def stop_components(
    engine: Engine, pending: PendingCommands, tasks: TaskScope, component_refs: Iterable[str], reason: str
) -> dict[str, str]:
    """Stop components side by side; requests for a stop that has not begun share it.

    Args:
        engine: where they are.
        pending: the commands that may run on them.
        tasks: owns the stops, which go on when the application that asked for them is gone.
        component_refs: the components; what has no command `stop` has only its commands ended.
        reason: a sentence for the applications whose commands end.

    Returns:
        Why a component did not say that it has stopped, by its reference; empty text where it did.
    """
    outcomes: dict[str, asyncio.Future[str]] = {}
    for ref in component_refs:
        if ref not in pending.stops:
            outcome = asyncio.get_running_loop().create_future()
            stopping = tasks.start(_stop(engine, pending, ref, reason, outcome))
            stopping.add_done_callback(partial(_give_up, outcome))
            pending.stops[ref] = outcome
        outcomes[ref] = pending.stops[ref]
    if outcomes:
        await asyncio.wait(outcomes.values())
    return {ref: outcome.result() for ref, outcome in outcomes.items()}


async def _stop(
    engine: Engine, pending: PendingCommands, component_ref: str, reason: str, outcome: asyncio.Future[str]
) -> None:
    failure = ""
    try:
        async with asyncio.timeout(STOP_TIMEOUT):
            before = pending.stopping.get(component_ref)
            if before is not None:
                await asyncio.wait({before}, timeout=PAUSE)
            # A request from now on needs another one: a command may have begun meanwhile.
            del pending.stops[component_ref]
            pending.stopping[component_ref] = outcome
            for command in pending.of(component_ref):
                command.stopping = reason
            profile = engine.components.get(component_ref)
            if profile is not None and profile.command("stop") is not None:
                await engine.invoke(component_ref, "stop")
    except TimeoutError:
        failure = f"no answer within {STOP_TIMEOUT:g} s"
    except RoISError as error:
        failure = str(error)
    finally:
        for stops in (pending.stops, pending.stopping):
            if stops.get(component_ref) is outcome:
                del stops[component_ref]
        for command in pending.of(component_ref):
            command.abort(reason)
    outcome.set_result(failure)
    if failure:
        _log.warning("%s did not confirm that it has stopped: %s", component_ref, failure)


def _give_up(outcome: asyncio.Future[str], _task: asyncio.Task[None]) -> None:
    """Settle a stop that failed or was cancelled, so that it does not keep its requests waiting."""
    if not outcome.done():
        outcome.set_result("the engine could not stop it")
