"""Exchangeable backends, found by entry points; the first that works is used."""

import logging
from collections.abc import Callable, Iterable
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Protocol, TypeVar

__all__ = ["Backend", "chosen"]

_log = logging.getLogger(__name__)


class Backend(Protocol):
    """A backend of any kind."""

    def available(self) -> tuple[bool, str]:
        """Return whether the backend works here, and if not, what to install; fast, and without side effects."""
        ...


_BackendT = TypeVar("_BackendT", bound=Backend)


@cache
def installed(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group, cached: finding them reads files of all installed packages."""
    return tuple(entry_points(group=group))


def chosen(
    group: str,
    offline: Callable[[], _BackendT],
    find: Callable[[str], Iterable[EntryPoint]] = installed,
) -> _BackendT:
    """Return the first backend of a group, by name, that works here; if there is none, the offline one.

    Args:
        group: of entry points; each is called without arguments and returns a backend.
        offline: makes the backend that comes with the package.
        find: looks entry points up.
    """
    for point in sorted(find(group), key=lambda each: each.name):
        try:
            backend: _BackendT = point.load()()
            works, reason = backend.available()
        except Exception as error:  # a backend may be third-party code: perception goes on without it
            works, reason = False, repr(error)
        if works:
            _log.info("%s: %s", group, point.name)
            return backend
        _log.warning("%s: %s does not work here: %s", group, point.name, reason)
    return offline()
