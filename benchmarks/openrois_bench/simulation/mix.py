"""What bodies and applications do while they are at work: the rates that a campaign runs and the formulas use. Pure."""

from typing import Final

from openrois_bench.simulation.paper import Load, Work

__all__ = ["COMMAND_SECONDS", "EVERY", "LOST", "RATES", "RESTART_EVERY", "SIGNS_A_SECOND", "at_work"]

RATES: Final = (1, 5)
"""Least and most events a second of a body."""

EVERY: Final = {"query": 10.0, "command": 60.0, "stream": 120.0, "return": 600.0}
"""Seconds after which an application does each of these again."""

COMMAND_SECONDS: Final = 3.0
"""How long a command takes; its body moves, and wants signs of life."""

SIGNS_A_SECOND: Final = 10.0
"""Signs of life of a gateway to a body that moves."""

RESTART_EVERY: Final = 3600.0
"""Seconds after which an adapter restarts."""

LOST: Final = 0.01
"""Share of restarts in which the connection is lost: the process was killed, or the network failed."""


def at_work(bodies: int, applications: int, gateways: int, seeing_all: float = 0.01) -> Load:
    """Return what bodies and applications do in a second, all of which receive the events of one body.

    Args:
        bodies: how many.
        applications: how many.
        gateways: that share them: a gateway notifies its own sessions of what comes and goes.
        seeing_all: share of applications that have every body of a gateway in their scope.
    """
    events = sum(RATES) / 2
    restarts = bodies / RESTART_EVERY
    commands = applications / EVERY["command"]
    concerned = applications / bodies + seeing_all * applications / gateways
    return Load(
        bodies,
        applications,
        Work(
            attach=restarts,
            session=applications / EVERY["return"],
            leave=applications / EVERY["return"],
            query=applications / EVERY["query"],
            command=commands,
            event=bodies * events,
            delivery=applications * events,
            stream=applications / EVERY["stream"],
            sign=commands * COMMAND_SECONDS * SIGNS_A_SECOND,
            # Each is notified that the body has gone, and that it is back.
            change=2 * restarts * concerned,
            fault=restarts * LOST * applications / gateways,
        ),
    )
