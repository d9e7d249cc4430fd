"""Pytest plugin: sources, paths and sinks for tests, whose figures are in the report of a test that fails.

A project asks for it in its conftest: `pytest_plugins = ["openrois_streaming.testing.plugin"]`. The fixtures are
factories; they need no plugin for asynchronous tests beside the one in use. Nothing of the media plane is
imported before a fixture is used.
"""

import zlib
from collections.abc import Callable, Generator
from typing import TYPE_CHECKING, Any, Literal, Protocol

import pytest

if TYPE_CHECKING:
    from openrois_streaming.source.source import MediaSource
    from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink

_MADE = pytest.StashKey[list[tuple[str, Callable[[], str]]]]()


class MakeSource(Protocol):
    """Factory of a synthetic source: colour bars, a talking head or a tone, with the arguments of its class."""

    def __call__(
        self, kind: Literal["bars", "head", "tone"] = "bars", *args: Any, **options: Any
    ) -> "MediaSource[Any]":
        """Make one, on this machine's clock."""
        ...


class MakePath(Protocol):
    """Factory of an `ImpairedPath`, which treats the same datagrams alike in every run of a test."""

    def __call__(self, down: "Impairments | None" = None, up: "Impairments | None" = None) -> "ImpairedPath":
        """Make one, to be entered with `async with`."""
        ...


class MakeSink(Protocol):
    """Factory of a `MeasuringSink`; the arguments are those of the class."""

    def __call__(self, **options: Any) -> "MeasuringSink":
        """Make one, to be entered with `async with`."""
        ...


@pytest.fixture
def synthetic_source() -> MakeSource:
    """A factory of sources of known pictures and sound."""
    from openrois_streaming.clock import SystemClock
    from openrois_streaming.synthetic import ColourBars, TalkingHead, Tone

    def make(kind: Literal["bars", "head", "tone"] = "bars", *args: Any, **options: Any) -> "MediaSource[Any]":
        kinds: dict[str, Callable[..., MediaSource[Any]]] = {"bars": ColourBars, "head": TalkingHead, "tone": Tone}
        return kinds[kind](*args, **{"clock": SystemClock(), **options})

    return make


@pytest.fixture
def impaired_path(request: pytest.FixtureRequest) -> MakePath:
    """A factory of bad networks; their counts are reported when the test fails."""
    from openrois_streaming.testing import ImpairedPath

    def make(down: "Impairments | None" = None, up: "Impairments | None" = None) -> ImpairedPath:
        path = ImpairedPath(down, up, seed=zlib.crc32(request.node.nodeid.encode()))
        _remember(request, "impaired path", lambda: f"down: {path.down.figures()}\nup: {path.up.figures()}")
        return path

    return make


@pytest.fixture
def measuring_sink(request: pytest.FixtureRequest) -> MakeSink:
    """A factory of measuring viewers; their figures are reported when the test fails."""
    from openrois_streaming.testing import MeasuringSink

    def make(**options: Any) -> MeasuringSink:
        sink = MeasuringSink(**options)
        _remember(request, "measuring sink", lambda: str(sink))
        return sink

    return make


def _remember(request: pytest.FixtureRequest, name: str, tell: Callable[[], str]) -> None:
    request.node.stash.setdefault(_MADE, []).append((name, tell))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the figures to the report of a test that has failed."""
    report = yield
    if report.when == "call" and report.failed:
        report.sections.extend((name, tell()) for name, tell in item.stash.get(_MADE, []))
    return report
