"""Exchangeable backends, found by entry points; the first that works is used."""

import logging
from collections.abc import Callable, Collection, Iterable
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Protocol, TypeVar

__all__ = ["Backend", "chosen", "installed", "named"]

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
    *,
    settings: tuple[object, ...] = (),
    own: Collection[str] = (),
) -> _BackendT:
    """Return the first backend of a group, by name, that works here; if there is none, the offline one.

    Args:
        group: of entry points; each is called with `settings` and returns a backend.
        offline: makes the backend that comes with the package.
        find: looks entry points up.
        settings: the arguments.
        own: names of those that come with the package, and are used only where they are asked for.
    """
    for point in sorted(find(group), key=lambda each: each.name):
        if point.name in own:
            continue
        try:
            backend: _BackendT = point.load()(*settings)
            works, reason = backend.available()
        except Exception as error:  # a backend may be third-party code: perception goes on without it
            works, reason = False, repr(error)
        if works:
            _log.info("%s: %s", group, point.name)
            return backend
        _log.warning("%s: %s does not work here: %s", group, point.name, reason)
    return offline()


def named(
    group: str, name: str, settings: object, find: Callable[[str], Iterable[EntryPoint]] = installed
) -> tuple[Any, str]:
    """Return the backend of a name, and why it does not work here; an empty text: it works.

    Args:
        group: of entry points; each is called with `settings` and returns a backend.
        name: of the entry point.
        settings: the argument.
        find: looks entry points up.

    Raises:
        ValueError: there is none of this name, or it cannot be loaded; a sentence for a person.
    """
    points = {point.name: point for point in find(group)}
    if name not in points:
        raise ValueError(f"there is no {name!r}; there are {', '.join(sorted(points)) or 'none'}")
    try:
        backend = points[name].load()(settings)
        works, reason = backend.available()
    except Exception as error:  # it may be third-party code, and the user has asked for it
        raise ValueError(f"{name} cannot be loaded: {error!r}") from error
    return backend, "" if works else reason
