"""The coverage-guided fuzzers of the parsers, each for as many cases as continuous integration has time for."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

GUIDED = Path(__file__).with_name("guided.py")
CASES = {"protocol": 250_000, "condition": 250_000, "values": 250_000, "profile_xml": 100_000}
CASES |= {
    "link": 25_000,
    "answer": 25_000,
    "candidate": 25_000,
    "datagram": 50_000,
    "pictures": 25_000,
    "reports": 25_000,
}


@pytest.mark.skipif(importlib.util.find_spec("atheris") is None, reason="atheris has no wheel for this platform")
@pytest.mark.long
@pytest.mark.timeout(300)
@pytest.mark.parametrize("target", CASES)
def test_no_input_breaks(target: str, tmp_path: Path) -> None:
    folder = tmp_path / target
    fuzzer = subprocess.run(
        [
            sys.executable,
            str(GUIDED),
            target,
            str(folder),
            f"-runs={CASES[target]}",
            "-seed=1",
            "-max_len=8192",
            "-timeout=5",
        ],
        capture_output=True,
        timeout=280,
        check=False,
    )
    said = fuzzer.stderr.decode("utf-8", "replace")
    # The traceback stands on the standard output.
    assert fuzzer.returncode == 0, fuzzer.stdout.decode("utf-8", "replace")[-4000:] + said[-1000:]
    assert f"Done {CASES[target]} runs" in said, said[-1000:]
