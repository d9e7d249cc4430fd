"""The figures for Prometheus as tables: name, kind, labels and meaning."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from openrois_agents.mind import figures as mind
from openrois_agents.mind.model import figures as model
from openrois_body import metrics as body
from openrois_media.metrics import figures as adapter
from openrois_robots.adapter import metrics as robots
from openrois_robots.kachaka import metrics as kachaka
from openrois_robots.reachy import metrics as reachy

from openrois.gateway import cluster_metrics as cluster
from openrois.gateway import metrics as gateway
from openrois.metrics.figure import Figure

__all__ = ["adapter_figures", "cluster_figures", "gateway_figures", "mind_figures"]

_HEAD: Final = ["| figure | kind | meaning |", "|---|---|---|"]

_GATEWAY: Final[tuple[tuple[str, Sequence[str], Sequence[Figure[Any]]], ...]] = (
    ("Connections", ("kind",), gateway.CONNECTION),
    (
        "The gateway",
        (),
        (*gateway.GATEWAY, *gateway.CONNECTION_LIMITS, *gateway.HEADER_TIMEOUTS, *gateway.FILES, *gateway.LAG),
    ),
    ("Bounds of connections", ("kind",), gateway.LIMITS),
    ("Keys of an issuer", (), gateway.KEYS),
    ("The certificate", (), gateway.CERTIFICATE),
    ("Refused, cut, ended", ("reason",), (*gateway.TURNED_AWAY, *gateway.CUT, *gateway.LEASES_ENDED)),
    ("Connections that ended", ("code",), gateway.CLOSED),
    ("Adapters", ("engine",), gateway.ADAPTER),
)
_CLUSTER: Final[tuple[tuple[str, Sequence[str], Sequence[Figure[Any]]], ...]] = (
    ("A gateway of a cluster", (), cluster.CLUSTER),
    ("Other gateways", ("gateway",), cluster.PEER),
    (
        "Claims, requests to other gateways, resumed sessions",
        ("outcome",),
        (*cluster.CLAIMS, *cluster.CALLS, *cluster.RESUMPTIONS),
    ),
)
_ADAPTER: Final[tuple[tuple[str, Sequence[str], Sequence[Figure[Any]]], ...]] = (
    ("The adapter", (), adapter.ADAPTER),
    ("Visitors", (), adapter.VISITORS),
    ("The guard of media", adapter.GUARD_LABELS, adapter.GUARD),
    ("Senses", body.SENSE_LABELS, body.SENSE),
    ("Input of operators", body.INPUT_LABELS, body.INPUT),
    ("Speech as sound", body.SPEECH_LABELS, (*body.SPEECH, *body.SPEECHES)),
    ("The link to a robot (Kachaka, Reachy Mini, ROS 2)", (), robots.LINK),
    ("A Kachaka's commands and velocities", kachaka.OUTCOMES, (*kachaka.COMMAND, *kachaka.VELOCITY)),
    ("A Kachaka's cameras", kachaka.CAMERA_LABELS, kachaka.CAMERA),
    ("A Reachy Mini's motions", (), reachy.MOTION),
    ("Sources", adapter.SOURCE_LABELS, adapter.SOURCE),
    ("Renditions", adapter.RENDITION_LABELS, adapter.RENDITION),
    ("Streams", adapter.STREAM_LABELS, (*adapter.STREAM, *adapter.ADAPTATION, *adapter.RECEPTION)),
)

_MIND: Final[tuple[tuple[str, Sequence[str], Sequence[Figure[Any]]], ...]] = (
    ("Conversations", (), mind.MIND_FIGURES),
    ("Refused turns", mind.REFUSAL_LABELS, mind.REFUSED),
    ("The language model, where there is one", (), model.MODEL_FIGURES),
)


def mind_figures() -> list[str]:
    """Return the tables of the figures of `openrois mind`."""
    return [line for group in _MIND for line in _table(*group)][:-1]


def gateway_figures() -> list[str]:
    """Return the tables of a gateway's figures, by their labels.

    Raises:
        ValueError: a figure of the gateway stands in none of the tables.
    """
    _require_all(gateway.FIGURES, _GATEWAY)
    lines = [line for group in _GATEWAY for line in _table(*group)]
    return [*lines, *_times(gateway.HISTOGRAMS)]


def cluster_figures() -> list[str]:
    """Return the tables of what a gateway of a cluster has besides, by their labels.

    Raises:
        ValueError: a figure stands in none of the tables.
    """
    _require_all(cluster.CLUSTER_FIGURES, _CLUSTER)
    lines = [line for group in _CLUSTER for line in _table(*group)]
    return [*lines, *_times(cluster.CLUSTER_HISTOGRAMS)]


def _times(histograms: Mapping[str, str]) -> list[str]:
    rows = [f"| `{name}` | histogram | {meaning} |" for name, meaning in histograms.items()]
    return [*_titled("Times", ("method",)), *_HEAD, *rows]


def adapter_figures() -> list[str]:
    """Return the tables of an adapter's figures, by their labels."""
    lines = [line for group in _ADAPTER for line in _table(*group)]
    rows = [
        f"| `{name}` | state set of {', '.join(f'`{state}`' for state in states)} | {meaning} |"
        for name, (meaning, states) in adapter.STATUSES.items()
    ]
    return [*lines, *_titled("Statuses", ()), *_HEAD, *rows]


def _table(title: str, labels: Sequence[str], figures: Iterable[Figure[Any]]) -> list[str]:
    rows = [f"| `{figure.name}` | {figure.kind} | {figure.help} |" for figure in figures]
    return [*_titled(title, labels), *_HEAD, *rows, ""]


def _titled(title: str, labels: Sequence[str]) -> list[str]:
    named = f"Labels: {', '.join(f'`{label}`' for label in labels)}." if labels else ""
    return [f"### {title}", "", *([named, ""] if named else [])]


def _require_all(
    figures: Sequence[Figure[Any]], groups: Sequence[tuple[str, Sequence[str], Sequence[Figure[Any]]]]
) -> None:
    grouped = {figure.name for _, _, members in groups for figure in members}
    if missing := {figure.name for figure in figures} - grouped:
        raise ValueError(f"these figures are in no table of tools.pages.figures: {', '.join(sorted(missing))}")
