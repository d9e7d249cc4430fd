"""docs/reference/limits.md: every limit of a gateway, its wire and of media, with number, figure and test."""

import ast
import importlib
import re
from collections import Counter
from functools import cache
from pathlib import Path
from typing import NamedTuple

from openrois_agents.mind.figures import MIND_FIGURES, REFUSED
from openrois_media.metrics import figures as avatar
from openrois_streaming.network.admission import AdmissionSettings
from openrois_streaming.network.session_limits import SessionLimits
from openrois_streaming.publish.encoder_limit import ENCODERS_LIMIT

from openrois.gateway.cluster_metrics import CLUSTER_FIGURES
from openrois.gateway.configuration import settings_of
from openrois.gateway.metrics import FIGURES, HISTOGRAMS
from openrois.gateway.socket import ADAPTER, APPLICATION

ROOT = Path(__file__).parents[1]

ELSEWHERE = ("client", "profiles", "testing")
"""Packages that are no part of a gateway or of what an adapter is written with."""

MEDIA = ("admission", "guard", "interfaces", "turns")
"""Modules of `openrois_streaming.network` that bound what comes in."""

VISITORS = ("registry", "relay")
"""Modules of `openrois_media.visitors` that bound who sends and who listens."""

NO_LIMITS = {
    "openrois.cluster.frames.FRAME_HEAD": "a length of the format",
    "openrois.cluster.frames.PROTOCOL": "a version",
    "openrois.cluster.dial_failed.LOST": "a code",
    "openrois.cluster.postgres.schema.NEWEST": "a version",
    "openrois.cluster.postgres.schema.VERSION": "a version",
    "openrois.gateway.adapters.TRY_AGAIN_LATER": "a code",
    "openrois.gateway.applications.RESUMED": "a code",
    "openrois.gateway.draining.SERVICE_RESTART": "a code",
    "openrois.gateway.token_expiry.TOKEN_ENDED": "a code",
    "openrois.journal.schema.APPLICATION_ID": "a code",
    "openrois.journal.schema.VERSION": "a version",
    "openrois.transport.stream.POLICY_VIOLATION": "a code",
    **{
        f"openrois.jsonrpc.protocol.{name}": "a code"
        for name in (
            *("PARSE_ERROR", "INVALID_REQUEST", "METHOD_NOT_FOUND", "INVALID_PARAMS", "INTERNAL_ERROR"),
            "TOO_MANY_REQUESTS",
        )
    },
}
"""Public numbers that bound nothing."""


class Row(NamedTuple):
    """A row of the page: one limit, or several that are read together."""

    limits: list[str]
    values: list[str]
    bounds: str
    beyond: str
    figures: list[str]
    tests: list[str]


def constants() -> dict[str, float]:
    """Return every public number of the control plane, signaling, agents and of what bounds media, by its name."""
    found: dict[str, float] = {}
    folders = (ROOT / "openrois", ROOT / "signaling" / "openrois_signaling", ROOT / "agents" / "openrois_agents")
    for folder in folders:
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder.parent).with_suffix("").parts
            if parts[1] not in ELSEWHERE:
                module = ".".join(part for part in parts if part != "__init__")
                found |= {f"{module}.{name}": value for name, value in numbers(module, path)}
    for module in (
        *(f"openrois_streaming.network.{name}" for name in MEDIA),
        *(f"openrois_media.visitors.{name}" for name in VISITORS),
    ):
        path = (ROOT / "streaming").joinpath(*module.split(".")).with_suffix(".py")
        found |= {f"{module}.{constant}": value for constant, value in numbers(module, path)}
    return {name: value for name, value in found.items() if name not in NO_LIMITS}


def numbers(module: str, path: Path) -> list[tuple[str, float]]:
    """Return the names and values of a module's own constants that are numbers."""
    found = []
    for statement in ast.parse(path.read_text(encoding="utf-8")).body:
        targets = [statement.target] if isinstance(statement, ast.AnnAssign) else getattr(statement, "targets", [])
        for target in targets:
            if isinstance(target, ast.Name) and target.id.isupper() and not target.id.startswith("_"):
                value = getattr(importlib.import_module(module), target.id)
                if isinstance(value, int | float) and not isinstance(value, bool):
                    found.append((target.id, float(value)))
    return found


def settings() -> dict[str, float]:
    """Return every setting that is a number, by its name in a configuration file; the port bounds nothing."""
    numeric = [each for each in settings_of() if each.info.annotation in (int, float) and each.field != "port"]
    return {f"[{each.table}] {each.key}": float(each.info.default) for each in numeric}


def options() -> dict[str, float]:
    """Return the limits that `openrois avatar` has options for, by the options' names."""
    admission = AdmissionSettings()
    encoders = {"--max-encoders": float(ENCODERS_LIMIT)}
    names = ("peer_packets", "peer_bytes", "total_packets", "total_bytes")
    places = SessionLimits()
    encoders |= {
        f"--{name.replace('_', '-')}": float(getattr(places, name))
        for name in ("applications", "kept_for_operators", "answer_time")
    }
    return encoders | {f"--{name.replace('_', '-')}": float(getattr(admission, name)) for name in names}


def profiles() -> dict[str, float]:
    """Return the bounds of both kinds of connection."""
    return {
        f"openrois.gateway.socket.{kind}.{name}": float(getattr(profile, name))
        for kind, profile in (("APPLICATION", APPLICATION), ("ADAPTER", ADAPTER))
        for name in profile.__dataclass_fields__
    }


@cache
def rows() -> list[Row]:
    """Return the rows of the tables."""
    page = (ROOT / "docs" / "reference" / "limits.md").read_text(encoding="utf-8")
    cells = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| `")]
    assert {len(each) for each in cells} == {6}
    return [
        Row(quoted(name), values.split(" / "), bounds, beyond, quoted(figures), quoted(tests))
        for name, values, bounds, beyond, figures, tests in cells
    ]


def quoted(cell: str) -> list[str]:
    """Return what stands between backticks."""
    return re.findall(r"`([^`]+)`", cell)


def short(name: str) -> str:
    """Return a limit as it is named on the page: a constant with its module, or the name of a setting or option."""
    return name if name[0] in "[-" else ".".join(name.split(".")[-2:])


@cache
def limits() -> dict[str, float]:
    """Return every limit and its number, by its name on the page."""
    known = constants() | settings() | options() | profiles()
    named = {short(name): value for name, value in known.items()}
    assert len(named) == len(known), "a name on the page is one limit"
    return named


@cache
def known_tests() -> Counter[str]:
    """Return how many files have a test of each name, by the name alone and with the name of the file."""
    found: Counter[str] = Counter()
    for path in (ROOT / "tests").rglob("test_*.py"):
        names = set(re.findall(r"def (test_\w+)\(", path.read_text(encoding="utf-8")))
        found.update(names)
        found.update(f"{path.name}::{name}" for name in names)
    return found


def full(name: str) -> str:
    """Return a figure's whole name."""
    return name if name.startswith("openrois_") else f"openrois_gateway_{name}"


def test_every_limit_has_a_row_and_every_row_a_limit() -> None:
    assert Counter(name for row in rows() for name in row.limits) == Counter(limits().keys())


def test_what_is_no_limit_is_there() -> None:
    for name in NO_LIMITS:
        module, _, constant = name.rpartition(".")
        assert hasattr(importlib.import_module(module), constant), name


def test_the_numbers_are_those_that_hold() -> None:
    wrong = []
    for row in rows():
        said = [float(value.partition(" ")[0].replace(",", "")) for value in row.values]
        known = [limits()[name] for name in row.limits]
        if said != known and set(known) != set(said[:1]):
            wrong.append((row.limits, said, known))
    assert wrong == []


def test_every_row_says_what_it_bounds() -> None:
    assert [row.limits for row in rows() if not row.bounds or not row.beyond] == []


def test_the_figures_are_served() -> None:
    media = {figure.name for figure in avatar.ADAPTER} | {figure.name for figure in avatar.GUARD}
    media |= {figure.name for figure in avatar.SOURCE} | {figure.name for figure in avatar.VISITORS}
    served = {figure.name for figure in (*FIGURES, *CLUSTER_FIGURES)} | media | set(HISTOGRAMS)
    served |= {figure.name for figure in MIND_FIGURES} | {figure.name for figure in REFUSED}
    assert {full(name) for row in rows() for name in row.figures} <= served


def test_the_tests_are_there() -> None:
    assert [row.limits for row in rows() if not row.tests] == []
    named = [name if "::" in name else f"test_{name}" for row in rows() for name in row.tests]
    assert [name for name in named if known_tests()[name] != 1] == []
