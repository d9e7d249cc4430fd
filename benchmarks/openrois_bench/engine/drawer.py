"""Draws the avatar, a process of its own, with the packages of any checkout.

Run as `drawer.py panda3d|puppet WIDTH HEIGHT`. It imports nothing of this package, which another checkout may not have.
"""

import sys
import time
from typing import Final

_SCENES: Final = ("rest", "speech", "wave")
_FPS: Final = 30


def draw(engine: str, width: int, height: int) -> None:
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
    lives = {scene: (Animator(), Life(0.0)) for scene in _SCENES}
    lives["speech"][0].speak(0.0, Track(0.0, [(n * 0.12, shapes[n % 6], 1.0) for n in range(5000)], 600.0))
    frames = dict.fromkeys(_SCENES, 0)
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


if __name__ == "__main__":
    draw(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
