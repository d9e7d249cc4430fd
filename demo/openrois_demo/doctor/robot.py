"""Finding about the simulated robot on this machine: whether its camera can be drawn. Needs `openrois[robot]`."""

import time

from openrois.extras import install_command
from openrois_demo.doctor.finding import Finding, Level

__all__ = ["simulated_robot"]


def simulated_robot() -> Finding:
    """Draw one picture of its rooms."""
    try:
        from openrois_robots.simulated.camera import SIZE
        from openrois_robots.simulated.drawing.renderer import Renderer
        from openrois_robots.simulated.drawing.view import View
        from openrois_robots.simulated.physics import Physics
        from openrois_robots.simulated.world.plan import APARTMENT

        Physics(APARTMENT)
        renderer = Renderer(APARTMENT, *SIZE)
        began = time.process_time()
        renderer.draw(View(APARTMENT.start))
        taken = time.process_time() - began
        renderer.close()
    except (ImportError, RuntimeError) as error:
        advice = f"{install_command('robot')} brings Panda3D; it also needs libX11.so.6 (Debian: libx11-6)."
        return Finding(Level.WARN, "simulated robot", str(error), advice)
    return Finding(Level.OK, "simulated robot", f"Panda3D draws {SIZE[0]}x{SIZE[1]}, in {1000 * taken:.0f} ms at first")
