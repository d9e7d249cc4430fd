"""The gateway's figures for Prometheus: integers that are kept where things happen, read when a scrape comes."""

import asyncio
import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from prometheus_client.core import Metric

from openrois.aio.loop_lag import LoopLag
from openrois.auth.jwks import KeySetCache
from openrois.auth.keys import KeySource
from openrois.gateway.cluster_metrics import cluster_families
from openrois.gateway.clustering import Clustering
from openrois.gateway.connection_limits import ConnectionLimits
from openrois.gateway.encryption import Certificate
from openrois.gateway.reloading import Reloader
from openrois.http_limits.header_timeout import HeaderTimeouts
from openrois.jsonrpc.connection_stats import Seen
from openrois.metrics.exposition import families, histogram, written
from openrois.metrics.figure import Figure
from openrois.session.session import EngineHost

__all__ = ["FIGURES", "HISTOGRAMS", "LABELLED", "Sources", "figures"]

_CODES: Final = frozenset({*range(1000, 1016), 4401, 4409})
KINDS: Final = ("application", "adapter")

CONNECTION: Final[tuple[Figure[Seen], ...]] = (
    Figure("openrois_gateway_connections", "gauge", "Connections.", lambda s: s.connections),
    Figure("openrois_gateway_connections_total", "counter", "Connections that were made.", lambda s: s.opened),
    Figure("openrois_gateway_requests_total", "counter", "Requests that were begun.", lambda s: s.requests),
    Figure("openrois_gateway_running_requests", "gauge", "Requests that are being served.", lambda s: s.running),
    Figure(
        "openrois_gateway_refused_requests_total",
        "counter",
        "Requests that were refused or failed in RoIS terms.",
        lambda s: s.refused,
    ),
    Figure(
        "openrois_gateway_crowded_requests_total",
        "counter",
        "Requests that were refused because there were too many.",
        lambda s: s.crowded,
    ),
    Figure(
        "openrois_gateway_urgent_requests_total",
        "counter",
        "Requests that were served before others.",
        lambda s: s.urgent,
    ),
    Figure("openrois_gateway_queued_requests", "gauge", "Requests that wait to be served.", lambda s: s.queued),
    Figure(
        "openrois_gateway_violations_total",
        "counter",
        "Malformed messages.",
        lambda s: s.violations,
    ),
    Figure(
        "openrois_gateway_internal_errors_total",
        "counter",
        "Requests and notifications that failed inside the gateway.",
        lambda s: s.failed,
    ),
    Figure(
        "openrois_gateway_unanswered_calls",
        "gauge",
        "Requests of the gateway's own that wait for an answer.",
        lambda s: s.unanswered,
    ),
    Figure(
        "openrois_gateway_outbox_messages",
        "gauge",
        "Messages that wait to be sent, on all connections.",
        lambda s: s.waiting,
    ),
    Figure(
        "openrois_gateway_outbox_most_messages",
        "gauge",
        "Messages that wait to be sent, on the connection where most do.",
        lambda s: s.most_waiting,
    ),
    Figure(
        "openrois_gateway_dropped_events_total",
        "counter",
        "Events dropped because a reader is too slow.",
        lambda s: s.dropped,
    ),
    Figure(
        "openrois_gateway_outbox_overflows_total",
        "counter",
        "Connections cut because the other side does not read.",
        lambda s: s.overflows,
    ),
    Figure("openrois_gateway_subscriptions", "gauge", "Subscriptions to events.", lambda s: s.subscriptions),
)
"""Of each kind of connection; the label `kind` is `application` or `adapter`."""

GATEWAY: Final[tuple[Figure[EngineHost], ...]] = (
    Figure("openrois_gateway_adapters", "gauge", "Engines attached.", lambda h: len(_engines(h))),
    Figure(
        "openrois_gateway_components",
        "gauge",
        "Components of all engines.",
        lambda h: len(h.engine.components),
    ),
    Figure(
        "openrois_gateway_unfinished_commands",
        "gauge",
        "Unfinished commands of all applications.",
        lambda h: h.commands.taken,
    ),
    Figure(
        "openrois_gateway_unfinished_commands_limit",
        "gauge",
        "Unfinished commands that there may be.",
        lambda h: h.commands.most,
    ),
    Figure(
        "openrois_gateway_unfinished_command_bytes",
        "gauge",
        "Bytes that are kept of unfinished commands.",
        lambda h: h.commands.text,
    ),
    Figure(
        "openrois_gateway_unfinished_command_bytes_limit",
        "gauge",
        "Bytes that may be kept of unfinished commands.",
        lambda h: h.commands.most_text,
    ),
    Figure(
        "openrois_gateway_subject_most_connections",
        "gauge",
        "Connections of the subject that has most; without tokens 0.",
        lambda h: h.quotas.most_connections,
    ),
    Figure(
        "openrois_gateway_subject_most_sessions",
        "gauge",
        "Sessions of the subject that has most, those that may be resumed included.",
        lambda h: h.quotas.most_sessions,
    ),
    Figure(
        "openrois_gateway_subject_most_streams",
        "gauge",
        "Streams of the subject that has most.",
        lambda h: h.quotas.most_streams,
    ),
    Figure(
        "openrois_gateway_unread_characters",
        "gauge",
        "Characters that wait to be sent, on all connections.",
        lambda h: h.unread.total,
    ),
    Figure(
        "openrois_gateway_unread_characters_limit",
        "gauge",
        "Characters that may wait to be sent.",
        lambda h: h.unread.most,
    ),
    Figure(
        "openrois_gateway_unread_cuts_total",
        "counter",
        "Connections cut because all together had too much unread.",
        lambda h: h.unread.cuts,
    ),
    Figure(
        "openrois_gateway_leases",
        "gauge",
        "Components that an application holds.",
        lambda h: len(h.leases.model.holding.held()),
    ),
    Figure(
        "openrois_gateway_lease_requests",
        "gauge",
        "Requests for a component that wait.",
        lambda h: h.leases.model.waiting.count(),
    ),
    Figure(
        "openrois_gateway_loans",
        "gauge",
        "Parts that were taken for a time from a holder of lower rank.",
        lambda h: h.leases.model.loans.count(),
    ),
    Figure(
        "openrois_gateway_absent_holders",
        "gauge",
        "Holders whose connection was lost and may be resumed.",
        lambda h: len(h.leases.model.absent),
    ),
    Figure(
        "openrois_gateway_stopped_engines",
        "gauge",
        "Engines that persons have stopped for programs.",
        lambda h: len(h.stop_latch),
    ),
    Figure(
        "openrois_gateway_stop_refusals_total",
        "counter",
        "Commands of programs that were refused because a person has stopped the engine.",
        lambda h: h.stops.refused,
    ),
    Figure(
        "openrois_gateway_journal_waiting",
        "gauge",
        "Journal records that wait to be written.",
        lambda h: h.journal.waiting,
    ),
    Figure(
        "openrois_gateway_journal_lost_total", "counter", "Journal records that were lost.", lambda h: h.journal.lost
    ),
    Figure(
        "openrois_gateway_journal_failures_total",
        "counter",
        "Attempts to write the journal that failed.",
        lambda h: h.journal.failures,
    ),
    Figure(
        "openrois_gateway_journal_late_total",
        "counter",
        "Commands accepted before they were in the journal.",
        lambda h: h.journal.late,
    ),
    Figure(
        "openrois_gateway_untold_faults_total",
        "counter",
        "Faults of the gateway itself that were not reported: too many at a time.",
        lambda h: h.engine.mint.untold,
    ),
    Figure("openrois_gateway_draining", "gauge", "1 while the gateway is about to stop.", lambda h: h.draining),
    Figure("openrois_gateway_tasks", "gauge", "Tasks of the event loop.", lambda _h: len(asyncio.all_tasks())),
    Figure("openrois_gateway_threads", "gauge", "Threads of the process.", lambda _h: threading.active_count()),
    Figure("openrois_gateway_refusals_total", "counter", "Refusals in the audit trail.", lambda h: h.audit.refusals),
    Figure("openrois_gateway_actions_total", "counter", "Actions in the audit trail.", lambda h: h.audit.actions),
    Figure(
        "openrois_gateway_audit_waiting",
        "gauge",
        "Audit records that wait to be written.",
        lambda h: h.audit.waiting,
    ),
    Figure(
        "openrois_gateway_audit_lost_total",
        "counter",
        "Audit records that were lost.",
        lambda h: h.audit.lost,
    ),
    Figure(
        "openrois_gateway_audit_failures_total",
        "counter",
        "Attempts to write the audit trail that failed.",
        lambda h: h.audit.failures,
    ),
)

LAG: Final[tuple[Figure[LoopLag], ...]] = (
    Figure(
        "openrois_gateway_loop_lag_seconds",
        "gauge",
        "By how much the event loop was late, at most in the last minute.",
        lambda lag: lag.most,
    ),
    Figure(
        "openrois_gateway_loop_lag_seconds_total",
        "counter",
        "By how much the event loop was late, all together.",
        lambda lag: lag.total,
    ),
)

HEADER_TIMEOUTS: Final[tuple[Figure[HeaderTimeouts], ...]] = (
    Figure(
        "openrois_gateway_silent_connections",
        "gauge",
        "Connections whose next request has not come.",
        lambda header_timeouts: header_timeouts.silent,
    ),
    Figure(
        "openrois_gateway_open_connections",
        "gauge",
        "Open TCP connections of the port, silent ones included.",
        lambda header_timeouts: header_timeouts.open,
    ),
)

CONNECTION_LIMITS: Final[tuple[Figure[ConnectionLimits], ...]] = (
    Figure(
        "openrois_gateway_entering_connections",
        "gauge",
        "Applications that wait to be let in.",
        lambda connection_limits: connection_limits.waiting,
    ),
)

KEYS: Final[tuple[Figure[KeySetCache], ...]] = (
    Figure(
        "openrois_gateway_key_fetches_total", "counter", "Attempts to fetch the issuer's keys.", lambda k: k.fetches
    ),
    Figure(
        "openrois_gateway_key_fetch_failures_total",
        "counter",
        "Fetches of the issuer's keys that failed.",
        lambda k: k.failures,
    ),
)
"""Where keys come from an issuer."""

FILES: Final[tuple[Figure[Reloader], ...]] = (
    Figure(
        "openrois_gateway_unusable_files_total",
        "counter",
        "Keys, certificates and lists that had changed and could not be used.",
        lambda reloader: reloader.failures,
    ),
)

CERTIFICATE: Final[tuple[Figure[Certificate], ...]] = (
    Figure(
        "openrois_gateway_certificate_end_seconds",
        "gauge",
        "When the certificate ends, in seconds since 1970.",
        lambda certificate: certificate.ends,
    ),
)
"""Where the gateway does TLS."""

LIMITS: Final[tuple[Figure[int], ...]] = (
    Figure("openrois_gateway_connections_limit", "gauge", "Connections that there may be, of each kind.", float),
)
"""With the label `kind`."""

TURNED_AWAY: Final[tuple[Figure[int], ...]] = (
    Figure("openrois_gateway_turned_away_total", "counter", "Connections that were refused, by reason.", float),
)
"""With the label `reason`."""

CUT: Final[tuple[Figure[int], ...]] = (
    Figure("openrois_gateway_cut_connections_total", "counter", "Connections that were cut, by reason.", float),
)
"""With the label `reason`."""

LEASES_ENDED: Final[tuple[Figure[int], ...]] = (
    Figure("openrois_gateway_leases_ended_total", "counter", "Leases that ended, by reason.", float),
)
"""With the label `reason`."""

CLOSED: Final[tuple[Figure[int], ...]] = (
    Figure("openrois_gateway_closed_connections_total", "counter", "Connections that ended, by close code.", float),
)
"""With the label `code`."""

ADAPTER: Final[tuple[Figure[int], ...]] = (
    Figure("openrois_gateway_adapter_up", "gauge", "1 for each engine that is attached.", float),
)
"""With the label `engine`."""

LABELLED: Final[tuple[Figure[Any], ...]] = (*KEYS, *CERTIFICATE, *TURNED_AWAY, *CUT, *LEASES_ENDED, *CLOSED, *ADAPTER)
"""Each has as many samples as there are values of its label; at first none."""

FIGURES: Final[tuple[Figure[Any], ...]] = (
    *CONNECTION,
    *GATEWAY,
    *LAG,
    *HEADER_TIMEOUTS,
    *CONNECTION_LIMITS,
    *FILES,
    *LIMITS,
    *LABELLED,
)

HISTOGRAMS: Final = {
    "openrois_gateway_request_seconds": "Time from a request of an application to its reply, by method.",
    "openrois_gateway_call_seconds": "Time from a request to an adapter to its reply, by method.",
}


@dataclass(frozen=True, slots=True)
class Sources:
    """Sources of the figures.

    Attributes:
        host: the gateway's engine and what its sessions share.
        lag: watches the event loop.
        header_timeouts: counts connections that wait for a request header.
        connection_limits: counts connections.
        keys: the source of keys for tokens; None where no token is needed.
        reloader: reads again what has changed.
        certificate: what TLS is done with; None for none.
        clustering: the gateway among others; None where it is on its own.
    """

    host: EngineHost
    lag: LoopLag
    header_timeouts: HeaderTimeouts
    connection_limits: ConnectionLimits
    keys: KeySource | None
    reloader: Reloader
    certificate: Certificate | None
    clustering: Clustering | None = None


async def figures(sources: Sources, accept: str) -> tuple[bytes, str]:
    """Read all figures, here, and write them in a thread in the format that `accept` (an HTTP header) prefers."""
    found = tuple(_families(sources))
    return await asyncio.to_thread(written, found, accept)


def _families(sources: Sources) -> Iterator[Metric]:
    host, connection_stats = sources.host, sources.host.connection_stats
    yield from families(CONNECTION, ("kind",), [((kind,), connection_stats.seen(kind)) for kind in KINDS])
    yield from families(GATEWAY, (), [((), host)])
    yield from families(LAG, (), [((), sources.lag)])
    yield from families(HEADER_TIMEOUTS, (), [((), sources.header_timeouts)])
    yield from families(CONNECTION_LIMITS, (), [((), sources.connection_limits)])
    yield from families(KEYS, (), [((), sources.keys)] if isinstance(sources.keys, KeySetCache) else [])
    yield from families(FILES, (), [((), sources.reloader)])
    yield from families(CERTIFICATE, (), [((), sources.certificate)] if sources.certificate is not None else [])
    most = sources.connection_limits.most_applications, sources.connection_limits.most_adapters
    limits = [((kind,), limit) for kind, limit in zip(KINDS, most, strict=True)]
    yield from families(LIMITS, ("kind",), limits)
    yield from families(
        TURNED_AWAY, ("reason",), [((why,), count) for why, count in connection_stats.turned_away.items()]
    )
    yield from families(CUT, ("reason",), [((why,), count) for why, count in connection_stats.cut.items()])
    yield from families(
        LEASES_ENDED, ("reason",), [((why,), count) for why, count in host.leases.carrier.ended.items()]
    )
    yield from families(CLOSED, ("code",), [((code,), count) for code, count in _codes(connection_stats.closed)])
    yield from families(ADAPTER, ("engine",), [((engine_id,), 1) for engine_id in _engines(host)])
    for name, latencies in zip(HISTOGRAMS, (connection_stats.latencies, connection_stats.call_latencies), strict=True):
        yield histogram(name, HISTOGRAMS[name], latencies)
    if sources.clustering is not None:
        yield from cluster_families(sources.clustering)


def _codes(closed: Mapping[int, int]) -> Iterator[tuple[str, int]]:
    """Give the codes that the protocol and this project know; the other side may close with any."""
    known = {code: count for code, count in closed.items() if code in _CODES}
    yield from ((str(code), count) for code, count in sorted(known.items()))
    if (others := sum(closed.values()) - sum(known.values())) > 0:
        yield "other", others


def _engines(host: EngineHost) -> list[str]:
    return host.engine.tree.sub_engine_ids
