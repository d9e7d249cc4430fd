"""Cost of a picture of the avatar to its engine: processor time to pose, draw and convert it, at rest and in speech.

`python -m openrois_bench.engine.drawing`, in the repository; `--other FOLDER` draws with the checkout in another folder
in turn with this one, a second of pictures each. The figure breathes, sways, blinks and glances as it does for viewers,
so no two pictures are alike. `--stills FOLDER` has the last picture of each scene written there, to be compared by eye.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from itertools import product
from pathlib import Path
from typing import IO, Final, cast

from openrois_bench.clone import ROOT, packages_of

SCENES: Final = ("rest", "speech", "wave")


class _Drawer:
    """A process that draws with a checkout."""

    def __init__(self, requests: IO[str], answers: IO[str]) -> None:
        self._requests, self._answers = requests, answers

    def draw(self, scene: str, still: str = "-") -> float:
        """Draw a second of a scene; seconds of processor time a picture."""
        print(scene, still, file=self._requests, flush=True)
        return float(self._answers.readline())


@contextmanager
def _drawer(checkout: Path, *arguments: str) -> Iterator[_Drawer]:
    path = os.pathsep.join(map(str, packages_of(checkout)))
    command = [sys.executable, "-P", str(Path(__file__).with_name("drawer.py")), *arguments]
    environment = {**os.environ, "PYTHONPATH": path, "PYGAME_HIDE_SUPPORT_PROMPT": "1"}
    with subprocess.Popen(
        command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=checkout
    ) as child:
        yield _Drawer(cast(IO[str], child.stdin), cast(IO[str], child.stdout))


def _measured(
    size: str, checkouts: Mapping[str, Path], chosen: argparse.Namespace
) -> dict[str, dict[str, list[float]]]:
    """Seconds a picture of each round, by scene and checkout."""
    runs: dict[str, dict[str, list[float]]] = {scene: {name: [] for name in checkouts} for scene in chosen.scenes}
    with ExitStack() as stack:
        drawers = {
            name: stack.enter_context(_drawer(checkout, chosen.engine, *size.split("x")))
            for name, checkout in checkouts.items()
        }
        for number in range(chosen.rounds + 1):
            for scene, name in product(chosen.scenes, drawers):
                still = "-" if chosen.stills is None else str(chosen.stills / f"{scene}-{size}-{name}.png")
                taken = drawers[name].draw(scene, still)
                if number:  # the first warms up
                    runs[scene][name].append(taken)
    return runs


def main() -> None:
    """Draw in turn, and print a line for each size, scene and checkout."""
    parser = argparse.ArgumentParser(
        prog="python -m openrois_bench.engine.drawing", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--other", type=Path, metavar="FOLDER", help="a checkout to compare with")
    parser.add_argument("--engine", choices=("panda3d", "puppet"), default="panda3d", help="(%(default)s)")
    parser.add_argument("--sizes", nargs="+", default=["640x360", "1280x720"], metavar="WIDTHxHEIGHT")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=SCENES, help="(all)")
    parser.add_argument("--rounds", type=int, default=20, help="of a second of pictures (%(default)s)")
    parser.add_argument("--stills", type=Path, metavar="FOLDER", help="write pictures there")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    chosen = parser.parse_args()
    checkouts = {"this": ROOT, **({} if chosen.other is None else {"other": chosen.other.resolve()})}
    runs = {size: _measured(size, checkouts, chosen) for size in chosen.sizes}
    for size, scenes in runs.items():
        for scene, taken in scenes.items():
            for name, rounds in taken.items():
                best = f"best {1000 * min(rounds):.2f}"
                print(f"{size} {scene:<6} {name:<5} {1000 * statistics.median(rounds):6.2f} ms ({best})")
            if chosen.other is not None:
                ratios = [one / other for one, other in zip(taken["this"], taken["other"], strict=True)]
                print(f"{size} {scene:<6} {statistics.median(ratios):.3f} of the other")
    if chosen.json is not None:
        load = os.getloadavg()
        chosen.json.write_text(json.dumps({"seconds a picture": runs, "load": load}, indent=1) + "\n")


if __name__ == "__main__":
    main()
