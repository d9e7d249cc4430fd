"""Figures in the text format that Prometheus reads."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate
from typing import Final, TypeVar

from prometheus_client import CollectorRegistry, PlatformCollector, ProcessCollector
from prometheus_client.core import (
    CounterMetricFamily,
    GaugeMetricFamily,
    HistogramMetricFamily,
    Metric,
    StateSetMetricFamily,
)
from prometheus_client.exposition import choose_encoder

from openrois.jsonrpc.latencies import BOUNDS, Latencies
from openrois.metrics.figure import Figure

__all__ = ["families", "histogram", "states", "written"]

_PROCESS: Final = CollectorRegistry()
PlatformCollector(registry=_PROCESS)
ProcessCollector(registry=_PROCESS)

OfT = TypeVar("OfT")


def written(found: Iterable[Metric], accept: str = "") -> tuple[bytes, str]:
    """The families, and those of the process, in the format that `accept` (an HTTP header) prefers; its content type.

    It takes milliseconds for each hundred samples; where `found` is a snapshot a thread may do it.
    """
    encode, content_type = choose_encoder(accept)
    registry = CollectorRegistry()
    registry.register(_Found(found))
    # Both formats are lines; only the newer one ends in a mark of its own.
    text: bytes = encode(registry)
    process: bytes = encode(_PROCESS)
    end = b"# EOF\n"
    return (process.removesuffix(end) + text), content_type


class _Found:
    """A collector that yields the families it was given."""

    def __init__(self, found: Iterable[Metric]) -> None:
        self._found = tuple(found)

    def collect(self) -> Iterator[Metric]:
        """Each figure with all its samples."""
        yield from self._found


def families(
    figures: Iterable[Figure[OfT]], labels: Sequence[str], things: Sequence[tuple[Sequence[str], OfT]]
) -> Iterator[Metric]:
    """Read each figure of each thing; with a thing stand the values of its labels."""
    for figure in figures:
        kind = CounterMetricFamily if figure.kind == "counter" else GaugeMetricFamily
        family = kind(figure.name, figure.help, labels=labels)
        for values, thing in things:
            value = figure.read(thing)
            if value is not None:
                family.add_metric(values, float(value))
        yield family


def histogram(name: str, meaning: str, latencies: Latencies) -> Metric:
    """Return the durations of calls, with the label `method`."""
    family = HistogramMetricFamily(name, meaning, labels=("method",))
    bounds = [*(str(bound) for bound in BOUNDS), "+Inf"]
    for method, counts, seconds in latencies:
        family.add_metric((method,), buckets=list(zip(bounds, accumulate(counts), strict=True)), sum_value=seconds)
    return family


def states(
    name: str,
    meaning: str,
    known: Sequence[str],
    labels: Sequence[str],
    things: Iterable[tuple[Sequence[str], str]],
) -> Metric:
    """Return a state set: of each thing exactly one of the known states is 1."""
    family = StateSetMetricFamily(name, meaning, labels=labels)
    for values, now in things:
        family.add_metric(values, {state: state == now for state in known})
    return family
