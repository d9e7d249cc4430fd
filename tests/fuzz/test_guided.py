"""The coverage-guided fuzzers of the parsers, each for as many cases as continuous integration has time for."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

GUIDED = Path(__file__).with_name("guided.py")
TIMES = int(os.environ.get("OPENROIS_FUZZ_TIMES", "1"))
"""How many times as long they search; ten times takes minutes, and is for changes of a parser."""

CASES = {
    "agent": 10_000,
    "model": 25_000,
    "protocol": 25_000,
    "nats": 25_000,
    "condition": 25_000,
    "values": 25_000,
    "speech": 25_000,
    "sound": 10_000,
    "events": 25_000,
    "profile_xml": 10_000,
    "datagram": 10_000,
}
CASES |= dict.fromkeys(("link", "answer", "candidate", "pictures", "reports"), 5_000)


@pytest.mark.skipif(importlib.util.find_spec("atheris") is None, reason="atheris has no wheel for this platform")
@pytest.mark.long
@pytest.mark.timeout(300 * TIMES)
@pytest.mark.parametrize("target", CASES)
def test_no_input_breaks(target: str, tmp_path: Path) -> None:
    folder, runs = tmp_path / target, CASES[target] * TIMES
    fuzzer = subprocess.run(
        [
            sys.executable,
            str(GUIDED),
            target,
            str(folder),
            f"-runs={runs}",
            "-seed=1",
            "-max_len=8192",
            "-timeout=5",
        ],
        capture_output=True,
        timeout=280 * TIMES,
        check=False,
    )
    said = fuzzer.stderr.decode("utf-8", "replace")
    # The traceback stands on the standard output.
    assert fuzzer.returncode == 0, fuzzer.stdout.decode("utf-8", "replace")[-4000:] + said[-1000:]
    assert f"Done {runs} runs" in said, said[-1000:]
