"""What can be exchanged for something better: who finds faces, and who tells them apart; found by entry points."""

import logging
from collections.abc import Callable, Iterable, Sequence
from importlib.metadata import EntryPoint, entry_points
from typing import Final, Protocol, TypeVar

from openrois_avatar.vision.box import Face
from openrois_avatar.vision.gallery import Likeness
from openrois_avatar.vision.view import View

__all__ = ["FINDERS", "RECOGNIZERS", "Backend", "FaceFinder", "FaceRecognizer", "chosen"]

_log = logging.getLogger(__name__)

FINDERS: Final = "openrois.face_finders"
RECOGNIZERS: Final = "openrois.face_recognizers"
"""The groups of entry points. Each is called without arguments and returns a backend."""


class Backend(Protocol):
    """What every backend can say."""

    def available(self) -> tuple[bool, str]:
        """Whether it works here, and if not, what to install; fast, and without side effects."""
        ...


class FaceFinder(Backend, Protocol):
    """Finds faces in pictures. It is called in a thread of its own, with one picture after the other of one camera."""

    def find(self, view: View, known: Sequence[Face]) -> Sequence[Face]:
        """Return all faces in the picture, also those that are known.

        Args:
            view: the picture.
            known: where faces are that are followed already, moved with the picture: a finder may look there first,
                and only now and then everywhere.
        """
        ...


class FaceRecognizer(Backend, Protocol):
    """Makes vectors of faces: the nearer two are (Euclidean distance), the more alike are the faces."""

    limit: float
    """The distance from which on two vectors are of different persons."""

    def likeness(self, view: View, face: Face) -> Likeness | None:
        """Return the vector of a face, or None where it is too small or too blurred to tell."""
        ...


_BackendT = TypeVar("_BackendT", bound=Backend)


def chosen(
    group: str,
    offline: Callable[[], _BackendT],
    find: Callable[..., Iterable[EntryPoint]] = entry_points,
) -> _BackendT:
    """Return the first backend of a group, by name, that works here and is not the offline one; else the offline one.

    Args:
        group: of entry points.
        offline: makes the one that always comes with the package.
        find: looks entry points up.
    """
    for point in sorted(find(group=group), key=lambda each: each.name):
        try:
            backend = point.load()()
            works, reason = backend.available()
        except Exception as error:  # whoever wrote it: perception goes on without it
            works, reason = False, repr(error)
        if works:
            _log.info("%s: %s", group, point.name)
            return backend  # type: ignore[no-any-return]
        _log.warning("%s: %s does not work here: %s", group, point.name, reason)
    return offline()
