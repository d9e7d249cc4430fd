"""Two network namespaces with a cable between them: senders in one, viewers in the other. Needs root and Linux."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

SENDER, VIEWERS = "10.203.0.1", "10.203.0.2"
"""Addresses at the ends of the cable; nothing else can reach them."""


@dataclass(frozen=True, slots=True)
class Network:
    """The names of the namespaces."""

    sender: str
    viewers: str


def inside(namespace: str, *command: str) -> list[str]:
    """The command line that runs `command` in a namespace."""
    return ["ip", "netns", "exec", namespace, *command]


@contextmanager
def network() -> Iterator[Network]:
    """Make the namespaces, and remove them in the end.

    Raises:
        subprocess.CalledProcessError: this user may not, or there is no `ip`.
    """
    made = Network(f"peers-{os.getpid()}-s", f"peers-{os.getpid()}-v")
    ends = {made.sender: (f"ps{os.getpid()}", SENDER), made.viewers: (f"pv{os.getpid()}", VIEWERS)}
    with ExitStack() as stack:
        for namespace in ends:
            _ip("netns", "add", namespace)
            stack.callback(_ip, "netns", "delete", namespace)
        (one, _), (other, _) = ends.values()
        _ip("link", "add", one, "type", "veth", "peer", "name", other)
        for namespace, (end, address) in ends.items():
            _ip("link", "set", end, "netns", namespace)
            _ip("-n", namespace, "address", "add", f"{address}/30", "dev", end)
            _ip("-n", namespace, "link", "set", end, "up")
            _ip("-n", namespace, "link", "set", "lo", "up")
        yield made


def _ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True)
