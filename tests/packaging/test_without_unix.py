"""Client, adapter and testing tools where modules and sockets of Unix are missing, as on Windows."""

import os
import subprocess
import sys
from typing import Final

import pytest

from tests.support.installations import files_marked_for
from tests.support.packages import ROOT

FOLDERS: Final = tuple(f"tests/openrois/{room}/" for room in ("adapter", "client", "testing"))

IMPORTING: Final = """
import sys
from tests.support.without_unix import ABSENT
import openrois.adapter, openrois.client, openrois.testing, openrois.cli.__main__, openrois_conformance.command
import openrois.profiles.command
sys.exit(1 if any(sys.modules.get(name) for name in ABSENT) else 0)
"""


def test_they_are_imported() -> None:
    done = subprocess.run([sys.executable, "-c", IMPORTING], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.long
@pytest.mark.timeout(600)
def test_their_tests_pass() -> None:
    files = [path for path in files_marked_for("base") if path.startswith(FOLDERS)]
    assert len(files) > 15
    selected = "extra(name='base') and not extra(name='gateway')"
    options = ("-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-p", "tests.support.without_unix", "-m", selected)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, *files],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=540,
        # All seeds are tried elsewhere: here it is found out whether anything is missing.
        env=os.environ | {"OPENROIS_SEEDS": "1"},
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    assert "skipped" not in done.stdout.splitlines()[-1]


def test_what_is_taken_away_is_missed() -> None:
    wrong = "import tests.support.without_unix, socket; socket.AF_UNIX"
    done = subprocess.run([sys.executable, "-c", wrong], cwd=ROOT, capture_output=True, text=True, check=False)
    assert "AF_UNIX" in done.stderr
    program = "import tests.support.without_unix, openrois.gateway.command"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert "ModuleNotFoundError" in done.stderr
