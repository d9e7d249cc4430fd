"""What a gateway of a cluster tells Prometheus besides: what it owns, the store, NATS, and work across gateways."""

from collections.abc import Iterator
from typing import Any, Final

from prometheus_client.core import Metric

from openrois.gateway.clustering import Clustering
from openrois.metrics.exposition import families, histogram
from openrois.metrics.figure import Figure

__all__ = ["CLUSTER_FIGURES", "CLUSTER_HISTOGRAMS", "cluster_families"]

CLUSTER: Final[tuple[Figure[Clustering], ...]] = (
    Figure(
        "openrois_gateway_owned_engines",
        "gauge",
        "Engines that this gateway owns.",
        lambda c: len(c.parts.directorate.claims),
    ),
    Figure(
        "openrois_gateway_claims_hold_seconds",
        "gauge",
        "Seconds for which its claims hold without another renewal.",
        lambda c: c.parts.directorate.hold_left,
    ),
    Figure(
        "openrois_gateway_used_up_engines",
        "gauge",
        "Engines without epochs: no lease of theirs begins until they are claimed again.",
        lambda c: c.parts.epochs.used_up,
    ),
    Figure(
        "openrois_gateway_store_up",
        "gauge",
        "1 while PostgreSQL takes claims of this gateway.",
        lambda c: not c.parts.directorate.problem,
    ),
    Figure(
        "openrois_gateway_store_steps_total",
        "counter",
        "Questions of ownership to PostgreSQL.",
        lambda c: c.parts.directorate.access.steps,
    ),
    Figure(
        "openrois_gateway_store_seconds_total",
        "counter",
        "Seconds that these took together.",
        lambda c: c.parts.directorate.access.seconds,
    ),
    Figure(
        "openrois_gateway_store_failures_total",
        "counter",
        "Those that failed, or were given up.",
        lambda c: c.parts.directorate.access.failures,
    ),
    Figure(
        "openrois_gateway_holdings_waiting",
        "gauge",
        "Components whose change of holder waits to be written to PostgreSQL.",
        lambda c: c.writer.waiting,
    ),
    Figure(
        "openrois_gateway_holdings_lost_total",
        "counter",
        "Changes of holders that were lost: too many waited.",
        lambda c: c.writer.lost,
    ),
    Figure(
        "openrois_gateway_holdings_failures_total",
        "counter",
        "Attempts to write changes of holders that failed.",
        lambda c: c.writer.failures,
    ),
    Figure(
        "openrois_gateway_nats_up",
        "gauge",
        "1 while NATS joins this gateway with others.",
        lambda c: not c.parts.link.trouble,
    ),
    Figure(
        "openrois_gateway_peers",
        "gauge",
        "Other gateways that are there, as this one hears them.",
        lambda c: len(c.federation.others),
    ),
    Figure(
        "openrois_gateway_stream_gaps_total",
        "counter",
        "Streams with other gateways that ended because NATS had dropped a message.",
        lambda c: c.parts.link.gaps,
    ),
    Figure(
        "openrois_gateway_sub_sessions",
        "gauge",
        "Sessions here of applications that are connected to other gateways; each of these gateways has one itself.",
        lambda c: c.sub_sessions,
    ),
)

PEER: Final[tuple[Figure[int], ...]] = (
    Figure("openrois_gateway_peer_streams", "gauge", "Open streams with each other gateway that is there.", float),
)
"""With the label `gateway`."""

CLAIMS: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_gateway_claims_total",
        "counter",
        "Claims: `granted`, `refused` because another adapter process brought the engine, `failed`.",
        float,
    ),
)
"""With the label `outcome`."""

CALLS: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_gateway_relayed_calls_total",
        "counter",
        "Requests to other gateways: `answered`, `refused` with an error, `late`, `lost` with their gateway; "
        "`unreached` counts sessions there that did not come about.",
        float,
    ),
)
"""With the label `outcome`."""

RESUMPTIONS: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_gateway_resumed_sessions_total",
        "counter",
        "Sessions resumed: `whole`, or `partial` where a gateway did not say what it has of them; attempts that were "
        "`refused`, or showed a used token (`replayed`).",
        float,
    ),
)
"""With the label `outcome`."""

CLUSTER_FIGURES: Final[tuple[Figure[Any], ...]] = (*CLUSTER, *PEER, *CLAIMS, *CALLS, *RESUMPTIONS)

CLUSTER_HISTOGRAMS: Final = {
    "openrois_gateway_relay_seconds": "Time from a request to another gateway to its reply, by method.",
}


def cluster_families(clustering: Clustering) -> Iterator[Metric]:
    """Yield the figures of a gateway of a cluster."""
    federation, streams = clustering.federation, clustering.parts.link.count_streams()
    yield from families(CLUSTER, (), [((), clustering)])
    yield from families(PEER, ("gateway",), [((each,), streams.get(each, 0)) for each in federation.others])
    counted = (
        (CLAIMS, clustering.parts.directorate.outcomes),
        (CALLS, federation.counts.calls),
        (RESUMPTIONS, federation.counts.resumptions),
    )
    for figures, outcomes in counted:
        yield from families(figures, ("outcome",), [((outcome,), count) for outcome, count in outcomes.items()])
    for name, meaning in CLUSTER_HISTOGRAMS.items():
        yield histogram(name, meaning, federation.counts.latencies)
