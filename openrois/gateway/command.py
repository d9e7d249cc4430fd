"""`openrois gateway`: run a gateway until it is stopped."""

import asyncio
import errno
import gc
import logging
import os
import resource
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import uvloop

from openrois.aio.memory_return import returning_memory
from openrois.aio.supervisor import Supervisor
from openrois.aio.tasks import TaskScope
from openrois.cluster.postgres.schema import StoreUnusable
from openrois.errors import StoreUnreachable
from openrois.gateway.clustering import Clustering
from openrois.gateway.configuration import configure, printed
from openrois.gateway.page import NO_PAGE, has_page
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.journal.file import JournalUnusable
from openrois.metrics.server import MetricsUnavailable
from openrois.observability.logs import set_up_logging

__all__ = ["main"]

_log = logging.getLogger(__name__)

_YOUNG: Final = 20_000
"""Objects by which there may be more than before until garbage is looked for among the new ones."""

_OTHER_FILES: Final = 1024
"""Open files of the gateway beside those of its connections: handshakes, logs, files that are served."""


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    try:
        configured = configure(arguments, os.environ)
    except ValueError as error:
        print(f"openrois gateway: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    settings = configured.settings
    if configured.print_only:
        print(printed(configured), end="")
        return 0
    try:
        set_up_logging(
            verbose=settings.verbose, form=settings.log_format, file=settings.log_file, secrets=settings.secrets()
        )
        for warning in configured.warnings:
            _log.warning("%s", warning)
        if configured.migrates_back:
            found = uvloop.run(Clustering.migrate_store_back(settings))
            print(f"the tables of the store had version {found}, and have version {found - 1} now")
            return 0
        _allow_files(settings)
        uvloop.run(_run(settings))
    except (JournalUnusable, MetricsUnavailable, StoreUnreachable, StoreUnusable, ValueError) as error:
        print(f"openrois gateway: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"openrois gateway: {_cannot_start(error, settings)}", file=sys.stderr)
        return 1
    return 0


def _cannot_start(error: OSError, settings: GatewaySettings) -> str:
    where = f"{settings.host}:{settings.port}"
    if error.filename:
        why = error.strerror
        if error.errno == errno.ENOENT:
            why = f"there is no folder {Path(error.filename).parent}"
        return f"{error.filename} cannot be written: {why}"
    if error.errno == errno.EADDRINUSE:
        return f"{where} is taken; is a gateway running already? choose another port with --port"
    return f"cannot listen at {where}: {error.strerror or error}"


async def _run(settings: GatewaySettings) -> None:
    loop, at_once, in_good_order = asyncio.get_running_loop(), asyncio.Event(), asyncio.Event()

    def terminate() -> None:
        (at_once if in_good_order.is_set() else in_good_order).set()

    loop.add_signal_handler(signal.SIGINT, at_once.set)
    loop.add_signal_handler(signal.SIGTERM, terminate)
    async with run_gateway(settings) as gateway, TaskScope() as tasks:
        loop.add_signal_handler(signal.SIGHUP, gateway.reload)
        print(f"listening {gateway.url}", flush=True)
        if not has_page():
            _log.warning("%s", NO_PAGE)
        _calm_the_collector()
        supervisor = Supervisor(os.environ)
        supervisor.notify_state(f"READY=1\nSTATUS=listening {gateway.url}")
        tasks.start(supervisor.watch())
        tasks.start(returning_memory())
        draining = tasks.start(_drain(in_good_order, gateway, supervisor))
        await asyncio.wait({draining, tasks.start(_wait(at_once))}, return_when=asyncio.FIRST_COMPLETED)


async def _drain(told: asyncio.Event, gateway: Gateway, supervisor: Supervisor) -> None:
    await told.wait()
    supervisor.notify_state("STOPPING=1")
    await gateway.drain()


async def _wait(told: asyncio.Event) -> None:
    await told.wait()


def _allow_files(settings: GatewaySettings) -> None:
    """Take as many open files as the system allows, up to what all places for connections need."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = settings.most_applications + settings.most_adapters + _OTHER_FILES
    allowed = wanted if hard == resource.RLIM_INFINITY else min(hard, wanted)
    if soft != resource.RLIM_INFINITY and soft < allowed:
        resource.setrlimit(resource.RLIMIT_NOFILE, (allowed, hard))
    if allowed < wanted:
        _log.warning(
            "the system allows %d open files, fewer than the %d that may be needed: raise it with `ulimit -n`",
            allowed,
            wanted,
        )


def _calm_the_collector() -> None:
    """Collect cyclic garbage less often, and not among the objects that stay for as long as the gateway does.

    Nearly everything here is freed by its last reference. By default a tenth of the time would go into looking, and the
    longest looks, of tens of milliseconds, go over all modules.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(_YOUNG, 10, 10)
