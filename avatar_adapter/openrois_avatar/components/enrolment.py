"""Enrolment: who PersonIdentification knows. A component of our own; what it keeps is biometric, and in memory only."""

import asyncio
from typing import Annotated, Final

from pydantic import Field

from openrois.adapter import BadParameter, Component, ComponentFailed, ComponentStatus, command, query
from openrois.errors import OutOfResources
from openrois_avatar.devices import Camera
from openrois_avatar.vision.gallery import MAX_ENROLLED, Gallery, Likeness
from openrois_avatar.vision.seen import Refs, Seen
from openrois_avatar.vision.watch import Watch

__all__ = ["LOOKS", "Enrolment"]

LOOKS: Final = 12
"""Looks at a face that are kept of one person."""
PATIENCE: Final = 15.0
"""Seconds within which they have to come."""

Name = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f\x7f]*$")]


class Enrolment(Component, authority="OpenRoIS", function="function"):
    """Remembers faces with names until the adapter ends or `forget`. Ask whoever it is before.

    Args:
        watch: what looks at the camera.
        camera: whose pictures they are.
        gallery: what is filled.
        refs: how those who are enrolled are called.
        patience: seconds that an enrolment may take.
    """

    def __init__(
        self, watch: Watch, camera: Camera, gallery: Gallery, refs: Refs, *, patience: float = PATIENCE
    ) -> None:
        super().__init__()
        self._watch = watch
        self._camera = camera
        self._gallery = gallery
        self._refs = refs
        self._patience = patience
        self._enrolling = False

    def condition(self) -> ComponentStatus:
        """ERROR where nothing can be seen, else READY, with a camera or without."""
        return ComponentStatus.ERROR if self._watch.failure else ComponentStatus.READY

    @command(result="person_ref")
    async def enrol(self, name: Name) -> str:
        """Remember the only person in front of the camera by this name, in place of whoever had it.

        Args:
            name: of the person, at most 64 characters
        """
        if not self._camera.is_connected:
            raise ComponentFailed("no camera is connected")
        if self._enrolling:
            raise ComponentFailed("another person is being enrolled already")
        if self._gallery.is_full and name not in self._gallery.names:
            raise OutOfResources(f"at most {MAX_ENROLLED} persons can be enrolled")
        self._enrolling = True
        try:
            self._gallery.enrol(name, await self._looks())
        finally:
            self._enrolling = False
        return self._refs.known(name)

    @command
    async def forget(self, name: Name) -> None:
        """Forget somebody's face.

        Args:
            name: as it was enrolled
        """
        if not self._gallery.forget(name):
            raise BadParameter(f"no person is enrolled as {name!r}")

    @query(result="names")
    async def enrolled(self) -> tuple[str, ...]:
        """Return the names of those who are enrolled."""
        return self._gallery.names

    async def _looks(self) -> list[Likeness]:
        looks = _Looks()
        leave = self._watch.seen.add(looks.take)
        try:
            with self._watch.collecting():
                async with asyncio.timeout(self._patience):
                    await looks.enough.wait()
        except TimeoutError:
            raise ComponentFailed(f"no person was enrolled: {looks.trouble}") from None
        finally:
            leave()
        return looks.taken


class _Looks:
    """Looks at one person, one after the other; somebody else begins anew, and two at once are nobody."""

    def __init__(self) -> None:
        self.taken: list[Likeness] = []
        self.enough = asyncio.Event()
        self.trouble = "no face was seen"
        self._number = 0

    def take(self, seen: Seen) -> None:
        """Take what is seen in one picture."""
        faces = [person for person in seen.persons if person.face]
        if len(faces) != 1 or faces[0].number != self._number:
            self.taken.clear()
        if len(faces) > 1:
            self.trouble = f"{len(faces)} faces were seen, and there has to be one"
        for person in faces if len(faces) == 1 else ():
            self._number = person.number
            self.trouble = "the face is too small or was not seen for long enough; come nearer and look at the camera"
            if person.likeness is not None and len(self.taken) < LOOKS:
                self.taken.append(person.likeness)
        if len(self.taken) >= LOOKS:
            self.enough.set()
