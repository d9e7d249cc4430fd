"""docs/limits.md: every limit of a gateway, its wire and of media, with its number, its figure and its test."""

import ast
import importlib
import re
from pathlib import Path

from openrois_avatar.metrics import figures as avatar
from openrois_streaming.network.admission import AdmissionSettings
from openrois_streaming.network.places import PlaceRules
from openrois_streaming.publish.encoder_limit import ENCODERS_LIMIT

from openrois.gateway.configuration import settings_of
from openrois.gateway.metrics import FIGURES, HISTOGRAMS
from openrois.gateway.socket import ADAPTER, APPLICATION

ROOT = Path(__file__).parents[1]

ELSEWHERE = ("bench", "client", "profiles", "testing")
"""Packages that are no part of a gateway or of what an adapter is written with."""

MEDIA = ("admission", "guard", "interfaces", "turns")
"""Modules of `openrois_streaming.network` that bound what comes in."""

NO_LIMITS = {
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


def constants() -> dict[str, float]:
    """Return every public number of the control plane, of signaling and of what bounds media, by its dotted name."""
    found: dict[str, float] = {}
    for folder in (ROOT / "openrois", ROOT / "signaling" / "openrois_signaling"):
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder.parent).with_suffix("").parts
            if parts[1] not in ELSEWHERE:
                module = ".".join(part for part in parts if part != "__init__")
                found |= {f"{module}.{name}": value for name, value in numbers(module, path)}
    for name in MEDIA:
        module = f"openrois_streaming.network.{name}"
        path = ROOT / "streaming" / "openrois_streaming" / "network" / f"{name}.py"
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
    """Return every setting that is a number, by the name that docs/deploying.md gives it; the port bounds nothing."""
    numeric = [each for each in settings_of() if each.info.annotation in (int, float) and each.field != "port"]
    return {f"[{each.table}] {each.key}": float(each.info.default) for each in numeric}


def options() -> dict[str, float]:
    """Return what `openrois avatar` can be told to bound, by the options' names."""
    admission = AdmissionSettings()
    encoders = {"--max-encoders": float(ENCODERS_LIMIT)}
    names = ("peer_packets", "peer_bytes", "total_packets", "total_bytes")
    places = PlaceRules()
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


def rows() -> dict[str, tuple[str, str, str, str]]:
    """Return the tables: value, meaning, figure and test of each limit."""
    page = (ROOT / "docs" / "limits.md").read_text(encoding="utf-8")
    found = re.findall(r"^\| `([^`|]+)` \| ([^|]+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", page, re.MULTILINE)
    assert len({row[0] for row in found}) == len(found)
    return {row[0]: row[1:] for row in found}


def test_every_limit_has_a_row_and_every_row_a_limit() -> None:
    assert set(rows()) == set(constants()) | set(settings()) | set(options()) | set(profiles())


def test_what_is_no_limit_is_there() -> None:
    for name in NO_LIMITS:
        module, _, constant = name.rpartition(".")
        assert hasattr(importlib.import_module(module), constant), name


def test_the_numbers_are_those_that_hold() -> None:
    known = constants() | settings() | options() | profiles()
    wrong = {
        name: (value, known.get(name))
        for name, (value, *_) in rows().items()
        if float(value.partition(" ")[0].replace(",", "")) != known.get(name)
    }
    assert wrong == {}


def test_the_figures_are_served() -> None:
    media = {figure.name for figure in avatar.ADAPTER} | {figure.name for figure in avatar.GUARD}
    media |= {figure.name for figure in avatar.SOURCE}
    served = {figure.name for figure in FIGURES} | media | set(HISTOGRAMS)
    named = {name for _, _, figures, _ in rows().values() for name in re.findall(r"`([^`]+)`", figures)}
    assert named <= served
    assert {figures for _, _, figures, _ in rows().values() if "`" not in figures} <= {"none: it refuses nothing"}


def test_the_tests_are_there() -> None:
    texts: dict[str, str] = {}
    gone = []
    for _, _, _, reference in rows().values():
        path, _, function = reference.strip("`").partition("::")
        if path not in texts:
            texts[path] = (ROOT / path).read_text(encoding="utf-8")
        if not re.search(rf"def {function}\(", texts[path]):
            gone.append(reference)
    assert gone == []
