"""A plugin (`-p tests.branches`): every branch of the pure modules is run by their tests, or pytest fails.

Coverage is counted while modules are imported and while a test of `TESTS` runs: a branch that nothing but a whole
process happens to reach counts as not tested, and all other tests run at full speed. Works with and without workers.
"""

import io
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import Final

import pytest
from coverage import Coverage

from tests.support.packages import ROOT
from tests.test_branches import TESTS, files_of, pure_modules

_FOLDER: Final = "branches_folder"
"""The key under which a worker of pytest-xdist gets the folder of its data."""

_TESTS: Final = tuple(str(ROOT / path) for path in TESTS)


def _coverage(folder: str) -> Coverage:
    product = [module for module in pure_modules() if not module.startswith("openrois_bench.")]
    return Coverage(
        data_file=str(Path(folder) / "data"),
        data_suffix=True,
        branch=True,
        config_file=False,
        include=[str(ROOT / pattern) for module in product for pattern in files_of(module)],
    )


class _Counting:
    """Counts in a process that runs tests."""

    def __init__(self, folder: str) -> None:
        self._coverage = _coverage(folder)
        self._coverage.start()

    def pytest_collection_finish(self) -> None:
        """All modules are imported."""
        self._coverage.stop()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Count while one of the tests runs that count."""
        counts = str(item.path).startswith(_TESTS)
        if counts:
            self._coverage.start()
        try:
            return (yield)
        finally:
            if counts:
                self._coverage.stop()

    def pytest_sessionfinish(self) -> None:
        """Keep what was counted for the report."""
        self._coverage.stop()
        self._coverage.save()


class _Judging:
    """Puts together what all processes counted, and says what is missing."""

    def __init__(self, folder: tempfile.TemporaryDirectory[str]) -> None:
        self._folder = folder
        self._missing = ""

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: object) -> None:
        """Tell a worker where its data go."""
        node.workerinput[_FOLDER] = self._folder.name  # type: ignore[attr-defined]

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        """Fail if a branch is missing that no failed test may have left out."""
        with self._folder as folder:
            if exitstatus != pytest.ExitCode.OK:
                return
            together = _coverage(folder)
            together.combine()
            report = io.StringIO()
            if together.report(file=report, show_missing=True, skip_covered=True) < 100:
                self._missing = report.getvalue()
                session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Say which branches."""
        if self._missing:
            terminalreporter.section("branches of pure modules that their tests do not run", red=True)
            terminalreporter.write_line(self._missing)


def pytest_configure(config: pytest.Config) -> None:
    """Count in this process or in its workers; judge in the one that starts them."""
    told = getattr(config, "workerinput", {}).get(_FOLDER)
    if told is None:
        folder = tempfile.TemporaryDirectory()
        config.pluginmanager.register(_Judging(folder))
        told = folder.name
    if not config.getoption("numprocesses", None) or hasattr(config, "workerinput"):
        config.pluginmanager.register(_Counting(told))
