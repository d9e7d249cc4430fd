"""A network namespace with a cable to this one: the network of a viewer, that a test may change and block."""

import itertools
import os
import re
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    import ifaddr

__all__ = ["Namespace", "hide_cables_of_others", "missing", "namespace"]

_CABLE: Final = re.compile(r"or\d+-\d+-a")

_numbers = itertools.count(1)
_own: set[str] = set()
"""The interfaces by which the namespaces of this process are reached."""


def hide_cables_of_others() -> None:
    """Have this process use no address of a namespace that a test in another process has made.

    Media over it would end without a word when that test ends and its cable is taken away. Where the libraries of the
    media plane are not installed there is no media.
    """
    if find_spec("ifaddr") is None:
        return
    import ifaddr

    find = ifaddr.get_adapters

    def get_adapters(*arguments: Any, **options: Any) -> "Iterable[ifaddr.Adapter]":
        adapters = find(*arguments, **options)
        return [each for each in adapters if not _CABLE.fullmatch(each.name) or each.name in _own]

    ifaddr.get_adapters = get_adapters


class Namespace:
    """A network namespace.

    Attributes:
        here: the address of this machine by which it is reached from there.
        there: the address of what runs there; a test may change it.
    """

    def __init__(self, name: str, network: str) -> None:
        self.name = name
        self.here = f"{network}.1"
        self.there = f"{network}.2"
        self.cable = f"{name}-b"

    @property
    def prefix(self) -> tuple[str, ...]:
        """What a command begins with that runs there."""
        return ("ip", "netns", "exec", self.name)

    def configure(self, *arguments: str) -> None:
        """Run `ip` there."""
        _ip("-n", self.name, *arguments)

    def block_udp(self) -> None:
        """Let no UDP out."""
        self.configure("rule", "add", "ipproto", "udp", "blackhole")

    def move(self) -> None:
        """Have another address, and not the former one any more."""
        former, self.there = self.there, f"{self.here.rpartition('.')[0]}.{int(self.there.rpartition('.')[2]) + 1}"
        # The other way round the second one would go with the first.
        self.configure("addr", "del", f"{former}/24", "dev", self.cable)
        self.configure("addr", "add", f"{self.there}/24", "dev", self.cable)


def missing() -> str:
    """Return why no namespace can be made here, empty if one can."""
    if shutil.which("ip") is None:
        return "no `ip` is found; install it to run the tests with networks of their own (Debian: apt install iproute2)"
    try:
        with namespace():
            return ""
    except subprocess.CalledProcessError as error:
        return f"this machine does not permit network namespaces, run as root: {error.stderr.strip()}"


@contextmanager
def namespace() -> Iterator[Namespace]:
    """Make one; in the end it goes with its cable. What runs there has to have ended before."""
    number = next(_numbers)
    # Names of interfaces have 15 characters; networks of other processes are others.
    name = f"or{os.getpid() % 10**7}-{number}"
    made = Namespace(name, f"10.{64 + os.getpid() // 256 % 128}.{(os.getpid() + 61 * number) % 256}")
    _ip("netns", "add", name)
    _own.add(f"{name}-a")
    try:
        _ip("link", "add", f"{name}-a", "type", "veth", "peer", "name", made.cable, "netns", name)
        _ip("addr", "add", f"{made.here}/24", "dev", f"{name}-a")
        _ip("link", "set", f"{name}-a", "up")
        made.configure("addr", "add", f"{made.there}/24", "dev", made.cable)
        made.configure("link", "set", made.cable, "up")
        made.configure("link", "set", "lo", "up")
        yield made
    finally:
        with suppress(subprocess.CalledProcessError):
            _ip("link", "del", f"{name}-a")
        _ip("netns", "del", name)
        _own.discard(f"{name}-a")


def _ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True, timeout=20)
