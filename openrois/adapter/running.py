"""Running an adapter: makes an engine of components, and dials its gateway for as long as it runs."""

import asyncio
import logging
import os
import signal
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from typing import Final

from openrois.adapter.blocking import told_of_blocking
from openrois.adapter.deadman import DeadMan, HolderExtension
from openrois.adapter.dialer import serve_parent
from openrois.adapter.lifecycle import connected
from openrois.aio.memory_return import returning_memory
from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.contract import Extension
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.jsonrpc.heartbeat import Heartbeat
from openrois.observability.logs import set_up_logging
from openrois.session.session import EngineHost
from openrois.transport.address import adapter_urls
from openrois.transport.credentials import Credentials
from openrois.types.references import reference

__all__ = ["GATEWAY", "GATEWAY_VARIABLE", "hosted", "run", "serve"]

_log = logging.getLogger(__name__)

GATEWAY: Final = "ws://127.0.0.1:8765/adapter"
"""Address at which a gateway of this machine takes adapters: the default."""

GATEWAY_VARIABLE: Final = "OPENROIS_GATEWAY"
"""Environment variable with the gateway's address, or those of several with commas: one program for every place."""


_STOP_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)


@asynccontextmanager
async def hosted(
    engine_id: str, *components: Component, extension: Extension | None = None
) -> AsyncIterator[EngineHost]:
    """Make an engine of components and keep them connected to what they depend on while the block runs.

    Args:
        engine_id: leads every component_ref.
        components: each with a name of its own.
        extension: answers the streaming and signaling methods, where the engine has streams.

    Raises:
        BadParameter: `engine_id` or a component's name cannot be part of a reference, or a name stands twice.
    """
    registry = LocalRegistry(engine_id, components, extension=extension)
    engine = Engine(engine_id)
    await engine.attach(registry)
    # What runs is cancelled before anything is disconnected.
    async with connected(components), TaskScope() as tasks:
        heartbeat = Heartbeat()
        deadman = DeadMan(heartbeat, tasks)
        by_ref = {reference(engine_id, each.name): each for each in components}
        registry.guard, registry.extension = deadman.guard, HolderExtension(deadman, extension, by_ref)
        yield EngineHost(engine, tasks, heartbeat=heartbeat)


@asynccontextmanager
async def serve(
    *components: Component,
    engine_id: str,
    gateway: str | Sequence[str] | None = None,
    token_file: Path | str | None = None,
    ca_file: Path | str | None = None,
    extension: AbstractAsyncContextManager[Extension] | None = None,
) -> AsyncIterator[EngineHost]:
    """Serve components to a gateway while the block runs, and yield their engine; a connection that ends is made again.

    Args:
        components: each with a name of its own.
        engine_id: unique behind its gateway; leads every component_ref.
        gateway: its address, `ws://host:port/adapter` or the `http://host:port/` that it prints; unless given that of
            the environment (`OPENROIS_GATEWAY`), or else `ws://127.0.0.1:8765/adapter`. Of several, as a sequence or
            with commas between them, one at a time is served, and the next when that one is gone.
        token_file: holds the token that the gateway wants, and is read whenever it is needed; unless given that of
            the environment (`OPENROIS_TOKEN_FILE`).
        ca_file: authorities (PEM) that may have signed the gateway's certificate; unless given those of the
            environment (`OPENROIS_CA_FILE`), or else the system's.
        extension: methods beside the five, such as those of streams; entered before the components are connected, and
            left when they are disconnected.

    Raises:
        BadParameter: `engine_id` or a component's name cannot be part of a reference, or a name stands twice.
        ValueError: `gateway` names something that is no address of a gateway.
    """
    urls = adapter_urls(gateway or os.environ.get(GATEWAY_VARIABLE) or GATEWAY)
    async with AsyncExitStack() as stack:
        added = None if extension is None else await stack.enter_async_context(extension)
        host = await stack.enter_async_context(hosted(engine_id, *components, extension=added))
        tasks = await stack.enter_async_context(TaskScope())
        with told_of_blocking():
            tasks.start(serve_parent(host, *urls, credentials=Credentials.of_files(token_file, ca_file)))
            yield host


def run(
    *components: Component,
    engine_id: str,
    gateway: str | Sequence[str] | None = None,
    token_file: Path | str | None = None,
    ca_file: Path | str | None = None,
    extension: AbstractAsyncContextManager[Extension] | None = None,
    verbose: bool = False,
) -> None:
    """Serve components to a gateway until the process is told to stop (Ctrl-C, SIGTERM): the main of an adapter.

    The gateway need not be there yet, and may go and come back: the log, on standard error, says how things stand.

    Args:
        components: each with a name of its own.
        engine_id: unique behind its gateway; leads every component_ref.
        gateway: its address, `ws://host:port/adapter` or the `http://host:port/` that it prints; unless given that of
            the environment (`OPENROIS_GATEWAY`), or else `ws://127.0.0.1:8765/adapter`. Of several, as a sequence or
            with commas between them, one at a time is served, and the next when that one is gone.
        token_file: holds the token that the gateway wants, and is read whenever it is needed; unless given that of
            the environment (`OPENROIS_TOKEN_FILE`).
        ca_file: authorities (PEM) that may have signed the gateway's certificate; unless given those of the
            environment (`OPENROIS_CA_FILE`), or else the system's.
        extension: methods beside the five, such as those of streams; entered before the components are connected, and
            left when they are disconnected.
        verbose: log more.

    Raises:
        BadParameter: `engine_id` or a component's name cannot be part of a reference, or a name stands twice.
        ValueError: `gateway` names something that is no address of a gateway.
        SystemExit: what the environment names is none.
    """
    if gateway is None and (named := os.environ.get(GATEWAY_VARIABLE)):
        try:
            adapter_urls(named)
        except ValueError as error:
            raise SystemExit(f"{GATEWAY_VARIABLE}: {error}") from None
    set_up_logging(verbose=verbose)
    serving = serve(
        *components,
        engine_id=engine_id,
        gateway=gateway,
        token_file=token_file,
        ca_file=ca_file,
        extension=extension,
    )
    with suppress(KeyboardInterrupt), asyncio.Runner(loop_factory=_quick_loop()) as runner:
        runner.run(_serve_until_stopped(serving, engine_id))


def _quick_loop() -> Callable[[], asyncio.AbstractEventLoop] | None:
    """Return a factory of faster event loops; None where there is only asyncio's."""
    try:
        import uvloop
    except ModuleNotFoundError:
        return None
    return uvloop.new_event_loop


async def _serve_until_stopped(serving: AbstractAsyncContextManager[EngineHost], engine_id: str) -> None:
    stopped = asyncio.Event()
    loop = asyncio.get_running_loop()
    for name in _STOP_SIGNALS:
        with suppress(NotImplementedError):
            # Where the loop takes no signals, Ctrl-C is a KeyboardInterrupt.
            loop.add_signal_handler(name, stopped.set)
    async with serving, TaskScope() as tasks:
        tasks.start(returning_memory())
        await stopped.wait()
        for name in _STOP_SIGNALS:
            with suppress(NotImplementedError):
                # A second signal ends the process without waiting for components that do not end.
                loop.remove_signal_handler(name)
    _log.info("%s has stopped", engine_id)
