"""From a snapshot of all figures to the text that Prometheus reads."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from prometheus_client import CollectorRegistry, PlatformCollector, ProcessCollector
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric, StateSetMetricFamily
from prometheus_client.exposition import choose_encoder

from openrois_avatar.metrics.figures import (
    ADAPTATION,
    ADAPTER,
    GUARD,
    GUARD_LABELS,
    RECEPTION,
    RENDITION,
    RENDITION_LABELS,
    SOURCE,
    SOURCE_LABELS,
    STATUSES,
    STREAM,
    STREAM_LABELS,
    Figure,
    OfT,
    Snapshot,
)

__all__ = ["written"]

_PROCESS: Final = CollectorRegistry()
PlatformCollector(registry=_PROCESS)
ProcessCollector(registry=_PROCESS)


def written(snapshot: Snapshot, accept: str = "") -> tuple[bytes, str]:
    """The figures in the format that `accept` (an HTTP header) prefers, and its content type.

    It takes milliseconds for each hundred streams and touches nothing but the snapshot: a thread may do it.
    """
    encode, content_type = choose_encoder(accept)
    registry = CollectorRegistry()
    registry.register(_Families(snapshot))
    # Both formats are lines; only the newer one ends in a mark of its own.
    text: bytes = encode(registry)
    process: bytes = encode(_PROCESS)
    end = b"# EOF\n"
    return (process.removesuffix(end) + text), content_type


class _Families:
    """A collector that gives one snapshot."""

    def __init__(self, snapshot: Snapshot) -> None:
        self._snapshot = snapshot

    def collect(self) -> Iterator[Metric]:
        """Each figure with all its samples."""
        seen = self._snapshot
        streams = [((s.stream_id, s.component_ref, s.kind, s.codec or ""), s) for s in seen.streams]
        renditions = [((source, r.mime_type, r.size), r) for source, r in seen.renditions]
        sources = [((s.name,), s) for s in seen.sources]
        yield from _families(ADAPTER, (), [((), seen.process)])
        yield from _families(GUARD, GUARD_LABELS, [((reason,), count) for reason, count in seen.guarded])
        yield from _families(SOURCE, SOURCE_LABELS, sources)
        yield from _families(RENDITION, RENDITION_LABELS, renditions)
        yield from _families(STREAM, STREAM_LABELS, streams)
        adapted = [(labels, each.adaptation) for labels, each in streams if each.adaptation is not None]
        yield from _families(ADAPTATION, STREAM_LABELS, adapted)
        received = [(labels, each.reception) for labels, each in streams if each.reception is not None]
        yield from _families(RECEPTION, STREAM_LABELS, received)
        yield _states(
            "openrois_stream_status", STREAM_LABELS, ((labels, each.status.value) for labels, each in streams)
        )
        yield _states(
            "openrois_source_status", SOURCE_LABELS, ((labels, each.status.value.lower()) for labels, each in sources)
        )


def _families(
    figures: Iterable[Figure[OfT]], labels: Sequence[str], things: Sequence[tuple[Sequence[str], OfT]]
) -> Iterator[Metric]:
    for figure in figures:
        kind = CounterMetricFamily if figure.kind == "counter" else GaugeMetricFamily
        family = kind(figure.name, figure.help, labels=labels)
        for values, thing in things:
            value = figure.read(thing)
            if value is not None:
                family.add_metric(values, float(value))
        yield family


def _states(name: str, labels: Sequence[str], things: Iterable[tuple[Sequence[str], str]]) -> Metric:
    meaning, states = STATUSES[name]
    family = StateSetMetricFamily(name, meaning, labels=labels)
    for values, now in things:
        family.add_metric(values, {state: state == now for state in states})
    return family
