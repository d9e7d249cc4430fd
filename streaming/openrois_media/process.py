"""The process of an adapter that streams: behind its gateway, with metrics and health for those who run it."""

import logging
from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import AsyncExitStack
from functools import partial
from types import MappingProxyType
from typing import Final

from openrois.adapter.process import AdapterProcess
from openrois.metrics.server import serving_metrics
from openrois.observability.health import Readiness, healthz, readyz
from openrois.session.session import EngineHost
from openrois.transport.credentials import Credentials
from openrois_media.metrics.exposition import scraped
from openrois_media.metrics.figures import Snapshot

__all__ = ["serve_process"]

_log = logging.getLogger(__name__)

_NOTHING: Final[Mapping[str, Callable[[], bool]]] = MappingProxyType({})


async def serve_process(
    host: EngineHost,
    gateways: Sequence[str],
    credentials: Credentials,
    collect_figures: Callable[[], Awaitable[Snapshot]],
    metrics: tuple[str, int] | None,
    requirements: Mapping[str, Callable[[], bool]] = _NOTHING,
) -> None:
    """Serve an engine to its gateway until cancelled; print `ready <engine id>` once it is accepted.

    Args:
        host: the engine.
        gateways: `ws://host:port/adapter` of each that it may serve, one at a time.
        credentials: for the gateways.
        collect_figures: takes a snapshot of all metrics.
        metrics: host and port of `/metrics`, `/healthz` and `/readyz`; None for nowhere.
        requirements: what `/readyz` requires beside the gateway, as it is named where it does not hold, and whether
            it holds.

    Raises:
        MetricsUnavailable: the port is taken, or the address is not this machine's.
    """
    process = AdapterProcess(host.engine.engine_id)
    async with AsyncExitStack() as stack:
        if metrics is not None:
            readiness = Readiness()
            readiness.require("the gateway: it has not accepted this adapter", lambda: process.is_attached)
            for what, holds in requirements.items():
                readiness.require(what, holds)
            serving = serving_metrics(
                *metrics,
                partial(scraped, collect_figures),
                beside={"/healthz": healthz, "/readyz": partial(readyz, readiness, "")},
            )
            _log.info("metrics: %s", await stack.enter_async_context(serving))
        await process.serve(host, gateways, credentials)
