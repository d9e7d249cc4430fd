"""The file of a measurement: the command, the machine, and the summary; samples are left out of it."""

import json
import sys
from pathlib import Path
from typing import Any

from openrois_bench.measuring.conditions import Conditions

__all__ = ["write_result"]


def write_result(file: Path | None, module: str, found: Conditions, **summary: Any) -> None:
    """Write what came of a measurement; without a file nothing is written.

    Args:
        file: where to.
        module: what runs by `python -m`; the arguments of this process are added.
        found: the machine, the versions, and the load.
        summary: the figures, by name: medians and percentiles over all rounds.
    """
    if file is None:
        return
    told = {"command": " ".join(["python -m", module, *sys.argv[1:]]), "conditions": found.model_dump(), **summary}
    file.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
