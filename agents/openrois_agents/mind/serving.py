"""Serves the figures of a mind to Prometheus."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from openrois.extras import needing_extra
from openrois_agents.mind.figures import MIND_FIGURES, REFUSAL_LABELS, REFUSED, MindFigures
from openrois_agents.mind.model.figures import MODEL_FIGURES, ModelFigures

__all__ = ["serving_figures"]


@asynccontextmanager
async def serving_figures(host: str, port: int, mind: MindFigures, model: ModelFigures | None) -> AsyncIterator[str]:
    """Serve figures while the block runs; yields the address.

    Args:
        host: the address to listen on.
        port: the TCP port.
        mind: of conversations.
        model: of the language model; None where there is none.

    Raises:
        MissingExtra: the libraries for it are not installed.
        MetricsUnavailable: the port is taken, or the address is not this machine's.
    """
    with needing_extra("gateway"):
        from openrois.metrics.exposition import families, written
        from openrois.metrics.server import serving_metrics

    async def write(accept: str) -> tuple[bytes, str]:
        refusals = tuple(((reason,), count) for reason, count in mind.refusals.items())
        found = [*families(MIND_FIGURES, (), (((), mind),)), *families(REFUSED, REFUSAL_LABELS, refusals)]
        if model is not None:
            found += families(MODEL_FIGURES, (), (((), model),))
        return written(found, accept)

    async with serving_metrics(host, port, write) as address:
        yield address
