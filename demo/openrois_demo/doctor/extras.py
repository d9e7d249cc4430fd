"""Findings about the extras: each that is missing, what does not work without it, and the command that installs it."""

from collections.abc import Iterator
from typing import Final

from openrois.extras import EXTRAS, install_command, missing_modules
from openrois_demo.doctor.finding import Finding, Level

__all__ = ["PURPOSES", "extras"]

PURPOSES: Final = {
    "gateway": "no gateway and no tokens",
    "cluster": "no gateway that is one of several",
    "mcp": "no bodies as tools for agents",
    "streaming": "no streams",
    "livekit": "no body for LiveKit Agents, which has an environment of its own",
    "pipecat": "no body for Pipecat, likewise",
    "body": "no senses, voice or motion",
    "avatar": "no avatar",
    "speech": "no voice",
    "hearing": "no speech recognition",
    "panda3d": "no avatar in 3D",
    "puppet": "no avatar as a 2D puppet",
    "robot": "no simulated robot",
    "demo": "no demo, which needs all of them",
    "kachaka": "no Kachaka; its libraries need Python 3.12 or older",
    "reachy": "no Reachy Mini, or none that speaks",
    "ros2": "no robot that speaks ROS 2 without a ROS of its own",
}
"""What is missing without each extra."""


def extras() -> Iterator[Finding]:
    """Yield a finding for each extra that is not installed; applications and adapters need none of them."""
    missing = {extra: modules for extra in EXTRAS if (modules := missing_modules(extra))}
    if not missing:
        yield Finding(Level.OK, "extras", "all are installed")
    for extra, modules in missing.items():
        told = f"{PURPOSES[extra]}: {', '.join(modules)} {'is' if len(modules) == 1 else 'are'} not installed"
        level = Level.FAIL if extra == "streaming" else Level.WARN
        yield Finding(level, f"extra {extra}", told, install_command(extra))
