"""Which log lines are shown."""

import json
import logging
from collections.abc import Iterator
from pathlib import Path

import pytest

from openrois.observability.logs import LogFile, set_up_logging
from tests.support.packages import packages

SILENT = {"openrois_bench", "openrois_codegen", "openrois_conformance", "openrois_web_demo"}
OURS = tuple({path.rpartition("/")[2] for path in packages()} - SILENT)


@pytest.fixture(autouse=True)
def _levels() -> Iterator[None]:
    before = {name: logging.getLogger(name).level for name in OURS}
    handlers, level = logging.root.handlers[:], logging.root.level
    yield
    logging.root.handlers[:] = handlers
    logging.root.setLevel(level)
    for name, level in before.items():
        logging.getLogger(name).setLevel(level)


@pytest.mark.parametrize(("verbose", "level"), [(False, logging.INFO), (True, logging.DEBUG)])
def test_our_information_and_warnings_of_libraries(verbose: bool, level: int) -> None:
    set_up_logging(verbose=verbose)
    assert {logging.getLogger(f"{name}.module").getEffectiveLevel() for name in OURS} == {level}
    assert not logging.getLogger("aiohttp.server").isEnabledFor(logging.INFO)


def test_lines_go_to_a_file_as_json_and_without_secrets(tmp_path: Path) -> None:
    logging.root.handlers.clear()
    path = tmp_path / "log"
    set_up_logging(verbose=True, form="json", file=path, secrets=["correct horse battery"])
    (handler,) = logging.root.handlers
    assert isinstance(handler, LogFile)
    logging.getLogger("openrois.x").debug("it is %s", "correct horse battery")
    logging.getLogger("aiohttp").info("not this")
    handler.close()
    handler.close()
    (line,) = path.read_text().splitlines()
    assert json.loads(line)["message"] == "it is [hidden]"


def test_lines_go_to_standard_error(capsys: pytest.CaptureFixture[str]) -> None:
    logging.root.handlers.clear()
    set_up_logging(verbose=False)
    logging.getLogger("openrois.x").info("a\nb")
    assert capsys.readouterr().err.endswith(" I openrois.x: a\\nb\n")


def test_a_file_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        set_up_logging(verbose=False, file=tmp_path / "missing" / "log")
