"""How soon `openrois mcp` greets a host that starts it, and lists its tools: `python -m openrois_bench.agents.start`.

There is no gateway: a host has its greeting before any is asked.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Final

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import MILLISECONDS, Percentiles
from openrois_bench.measuring.result import write_result

__all__ = ["main"]

_COMMAND: Final = (sys.executable, "-m", "openrois.cli", "mcp", "--gateway", "ws://127.0.0.1:1/")
_GREETING: Final = {
    "protocolVersion": "2025-11-25",
    "capabilities": {},
    "clientInfo": {"name": "openrois-bench", "version": "1"},
}


@dataclass(frozen=True, slots=True)
class Start:
    """One start, in seconds from the moment at which the process was begun.

    Attributes:
        greeted, listed: until the answer was read.
        greeted_cpu, listed_cpu: of a processor that the process had taken by then.
    """

    greeted: float
    greeted_cpu: float
    listed: float
    listed_cpu: float


def start() -> Start:
    """Start the process, greet it, list its tools, and end it."""
    began = time.monotonic()
    with subprocess.Popen(_COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        _send(process.stdin, {"id": 1, "method": "initialize", "params": _GREETING})
        _require_result(process.stdout.readline())
        greeted, greeted_cpu = time.monotonic() - began, _cpu(process.pid)
        _send(process.stdin, {"method": "notifications/initialized"})
        _send(process.stdin, {"id": 2, "method": "tools/list"})
        _require_result(process.stdout.readline())
        listed, listed_cpu = time.monotonic() - began, _cpu(process.pid)
        process.stdin.close()
    return Start(greeted, greeted_cpu, listed, listed_cpu)


def _send(stdin: IO[str], message: dict[str, Any]) -> None:
    stdin.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
    stdin.flush()


def _require_result(line: str) -> None:
    assert "result" in json.loads(line), line


def _cpu(pid: int) -> float:
    """Return the seconds that a process has computed (proc(5): utime and stime)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.agents.start", description=__doc__)
    parser.add_argument("--runs", type=int, default=20, help="how many starts (%(default)s)")
    parser.add_argument("--json", type=Path, help="where the figures are written to")
    chosen = parser.parse_args(arguments)
    before = load()
    # The first one compiles modules.
    start()
    starts = [start() for _ in range(chosen.runs)]
    figures = {
        name: Percentiles.of((getattr(each, name) for each in starts), MILLISECONDS).model_dump()
        for name in Start.__dataclass_fields__
    }
    found = conditions(before)
    print(f"{found}\n\nmilliseconds from the start of the process:")
    print(json.dumps(figures, indent=1))
    write_result(chosen.json, "openrois_bench.agents.start", found, summary=figures)


if __name__ == "__main__":
    main()
