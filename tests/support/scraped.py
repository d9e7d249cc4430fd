"""A gateway's figures, read as Prometheus reads them."""

import aiohttp
from prometheus_client import Metric
from prometheus_client.parser import text_string_to_metric_families

from openrois.gateway.server import Gateway

__all__ = ["Samples", "scraped"]

Samples = dict[tuple[str, ...], float]


async def scraped(gateway: Gateway) -> dict[str, Samples]:
    """Values by the name of the sample and the values of its labels, in the order of the labels' names."""
    async with aiohttp.ClientSession() as http, http.get(gateway.metrics) as answer:
        families: list[Metric] = list(text_string_to_metric_families(await answer.text()))
    found: dict[str, Samples] = {}
    for family in families:
        for sample in family.samples:
            found.setdefault(sample.name, {})[tuple(value for _, value in sorted(sample.labels.items()))] = sample.value
    return found
