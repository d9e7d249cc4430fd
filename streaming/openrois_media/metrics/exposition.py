"""Exposition of a snapshot as text for Prometheus."""

import asyncio
from collections.abc import Awaitable, Callable, Iterator

from prometheus_client.core import Metric

from openrois.metrics import exposition
from openrois.metrics.exposition import families, states
from openrois_media.metrics.figures import (
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
    VISITORS,
    Snapshot,
)

__all__ = ["scraped", "written"]


async def scraped(look: Callable[[], Awaitable[Snapshot]], accept: str) -> tuple[bytes, str]:
    """Take a snapshot, here, and write it in a thread."""
    return await asyncio.to_thread(written, await look(), accept)


def written(seen: Snapshot, accept: str = "") -> tuple[bytes, str]:
    """Return the figures in the format that `accept` (an HTTP header) prefers, and its content type.

    It takes milliseconds for each hundred streams and reads only the snapshot, so that a thread may do it.
    """
    return exposition.written(_families(seen), accept)


def _families(seen: Snapshot) -> Iterator[Metric]:
    """Yield each figure with all its samples."""
    streams = [((s.stream_id, s.component_ref, s.kind, s.codec or ""), s) for s in seen.streams]
    renditions = [((source, r.mime_type, r.size), r) for source, r in seen.renditions]
    sources = [((s.name,), s) for s in seen.sources]
    yield from families(ADAPTER, (), [((), seen.process)])
    yield from families(VISITORS, (), [] if seen.visitors is None else [((), seen.visitors)])
    yield from families(GUARD, GUARD_LABELS, [((reason,), count) for reason, count in seen.guarded])
    for group in seen.more:
        yield from families(group.figures, group.labels, group.samples)
    yield from families(SOURCE, SOURCE_LABELS, sources)
    yield from families(RENDITION, RENDITION_LABELS, renditions)
    yield from families(STREAM, STREAM_LABELS, streams)
    adapted = [(labels, each.adaptation) for labels, each in streams if each.adaptation is not None]
    yield from families(ADAPTATION, STREAM_LABELS, adapted)
    received = [(labels, each.reception) for labels, each in streams if each.reception is not None]
    yield from families(RECEPTION, STREAM_LABELS, received)
    for name, labels, things in (
        ("openrois_stream_status", STREAM_LABELS, [(labels, each.status.value) for labels, each in streams]),
        ("openrois_source_status", SOURCE_LABELS, [(labels, s.status.value.lower()) for labels, s in sources]),
    ):
        yield states(name, *STATUSES[name], labels, things)
