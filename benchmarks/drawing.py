"""What a picture of the avatar costs its engine: processor time to pose, draw and convert it, at rest and in speech.

`python -m benchmarks.drawing`, in the repository; `--other FOLDER` draws with the checkout in another folder in turn
with this one, a second of pictures each. The figure breathes, sways, blinks and glances as it does for viewers, so no
two pictures are alike. `--stills FOLDER` has the last picture of each scene written there, to be compared by eye.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from itertools import product
from pathlib import Path
from typing import IO, Final, cast

HERE: Final = Path(__file__).parent.parent
_PACKAGES: Final = ("", "signaling", "streaming", "avatar_adapter", "web_demo")
SCENES: Final = ("rest", "speech", "wave")
_FPS: Final = 30


def _child(engine: str, width: int, height: int) -> None:
    """Draw what is asked for on standard input, a line each: a scene and a file or "-"; tell seconds a picture."""
    from openrois_avatar.engines.animation.animator import Animator
    from openrois_avatar.engines.animation.visemes import Track
    from openrois_avatar.engines.room.life import Life
    from openrois_avatar.engines.runner import i420
    from openrois_avatar.engines.settings import Picture

    if engine == "panda3d":
        from openrois_avatar.engines.panda3d.stage import Stage
    else:
        from openrois_avatar.engines.puppet.stage import Stage  # type: ignore[assignment]

    stage, shapes = Stage(Picture(width, height, _FPS)), ("aa", "PP", "oh", "E", "FF", "sil")
    lives = {scene: (Animator(), Life(0.0)) for scene in SCENES}
    lives["speech"][0].speak(0.0, Track(0.0, [(n * 0.12, shapes[n % 6], 1.0) for n in range(5000)], 600.0))
    frames = dict.fromkeys(SCENES, 0)
    for line in sys.stdin:
        scene, still = line.split()
        animator, life = lives[scene]
        if scene == "wave":
            animator.react(frames[scene] / _FPS, "wave", "wave")
        begun = time.process_time()
        for _ in range(_FPS):
            moment = frames[scene] / _FPS
            frames[scene] += 1
            seen = life.advance(moment, scene != "rest")
            pixels = stage.draw(animator.pose(moment, life.walking), seen)
            i420(pixels).tobytes()
        print((time.process_time() - begun) / _FPS, flush=True)
        if still != "-":
            import cv2

            cv2.imwrite(still, pixels[:, :, :3])


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
    path = os.pathsep.join(str(checkout / package) for package in _PACKAGES)
    command = [sys.executable, __file__, "--child", *arguments]
    environment = {**os.environ, "PYTHONPATH": path}
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
    parser = argparse.ArgumentParser(prog="python -m benchmarks.drawing", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--other", type=Path, metavar="FOLDER", help="a checkout to compare with")
    parser.add_argument("--engine", choices=("panda3d", "puppet"), default="panda3d", help="(%(default)s)")
    parser.add_argument("--sizes", nargs="+", default=["640x360", "1280x720"], metavar="WIDTHxHEIGHT")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=SCENES, help="(all)")
    parser.add_argument("--rounds", type=int, default=20, help="of a second of pictures (%(default)s)")
    parser.add_argument("--stills", type=Path, metavar="FOLDER", help="write pictures there")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    parser.add_argument("--child", nargs=3, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.child:
        engine, width, height = chosen.child
        _child(engine, int(width), int(height))
        return
    checkouts = {"this": HERE, **({} if chosen.other is None else {"other": chosen.other.resolve()})}
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
