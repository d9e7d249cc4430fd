"""Enrolment: the persons that PersonIdentification knows. A component of OpenRoIS; biometric data, in memory only."""

import asyncio
from collections.abc import Callable
from typing import Annotated, Final

from openrois_media.devices import Camera
from pydantic import Field

from openrois.adapter import BadParameter, Component, ComponentFailed, ComponentStatus, command, query
from openrois.errors import OutOfResources
from openrois_body.vision.gallery import MAX_ENROLLED, Gallery, Likeness
from openrois_body.vision.sighting import Refs, Sighting
from openrois_body.vision.watch import Watch

__all__ = ["LOOKS", "Enrolment"]

LOOKS: Final = 12
"""Samples of a face that are kept of one person."""
PATIENCE: Final = 15.0
"""Seconds within which they have to be taken."""
_NO_CONSENT: Final = "the visitor does not consent to be recorded, as an enrolment does: ask for that first"

Name = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f\x7f]*$")]


class Enrolment(Component, authority="OpenRoIS", function="function"):
    """Remembers faces with names until the adapter ends or `forget`. Ask the person for consent before.

    A face of a visitor that has stated its consent is forgotten when the visitor withdraws that, or has left.

    Args:
        watch: analyses the camera's pictures.
        camera: source of the pictures.
        gallery: holds the enrolled persons.
        refs: makes the refs of enrolled persons.
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
        self._visitor_of: dict[str, str] = {}
        """The visitor_ref of each person whose face rests on the consent of a visitor, by name."""
        camera.keeping_ended.add(self._forget_visitor)

    def condition(self) -> ComponentStatus:
        """Return ERROR where pictures cannot be analysed, else READY, with a camera or without."""
        return ComponentStatus.ERROR if self._watch.problem() else ComponentStatus.READY

    def problem(self) -> str:
        """Return why pictures cannot be analysed."""
        return self._watch.problem()

    @command(result="person_ref")
    async def enrol(self, name: Name) -> str:
        """Enrol the only person in front of the camera by this name, replacing another person of the name.

        Args:
            name: of the person, at most 64 characters
        """
        if not self._camera.is_connected:
            raise ComponentFailed("no camera is connected; connect an uplink of VideoStreaming first")
        if self._enrolling:
            raise ComponentFailed("another enrolment is running; try again when it has ended")
        if self._gallery.is_full and name not in self._gallery.names:
            raise OutOfResources(f"{MAX_ENROLLED} persons are enrolled, which is the limit; forget one first")
        self._enrolling = True
        try:
            looks = await self._looks()
            self._gallery.enrol(name, looks.taken)
            self._visitor_of.pop(name, None)
            if self._camera.keeps_by_consent(looks.visitor_ref):
                self._visitor_of[name] = looks.visitor_ref
        finally:
            self._enrolling = False
        return self._refs.known(name)

    @command
    async def forget(self, name: Name) -> None:
        """Forget an enrolled person.

        Args:
            name: as it was enrolled
        """
        if not self._gallery.remove_person(name):
            raise BadParameter(f"no person is enrolled as {name!r}; the query `enrolled` lists the names")
        self._visitor_of.pop(name, None)

    @query(result="names")
    async def enrolled(self) -> tuple[str, ...]:
        """Return the names of the enrolled persons."""
        return self._gallery.names

    def _forget_visitor(self, visitor_ref: str) -> None:
        for name in [name for name, each in self._visitor_of.items() if each == visitor_ref]:
            del self._visitor_of[name]
            self._gallery.remove_person(name)

    async def _looks(self) -> "_Looks":
        looks = _Looks(self._camera.may_keep)
        leave = self._watch.seen.add(looks.add_seen)
        try:
            with self._watch.collecting():
                async with asyncio.timeout(self._patience):
                    await looks.enough.wait()
        except TimeoutError:
            raise ComponentFailed(f"no person was enrolled: {looks.trouble}") from None
        finally:
            leave()
        if not self._camera.may_keep(looks.visitor_ref):
            raise ComponentFailed(f"no person was enrolled: {_NO_CONSENT}")
        return looks


class _Looks:
    """Samples of one person's face; another person, or two at once, begin anew.

    Args:
        may_keep: tells whether what a visitor's camera shows may be kept.
    """

    def __init__(self, may_keep: Callable[[str], bool]) -> None:
        self._may_keep = may_keep
        self.visitor_ref = ""
        """Whose camera shows it; empty for the body's own."""
        self.taken: list[Likeness] = []
        self.enough = asyncio.Event()
        self.trouble = "no face was seen"
        self._number = 0

    def add_seen(self, seen: Sighting) -> None:
        """Add the face that one picture shows."""
        if not self._may_keep(seen.visitor_ref):
            self.taken.clear()
            self.trouble = _NO_CONSENT
            return
        if seen.visitor_ref != self.visitor_ref:
            self.visitor_ref = seen.visitor_ref
            self.taken.clear()
        faces = [person for person in seen.persons if person.face]
        if len(faces) != 1 or faces[0].number != self._number:
            self.taken.clear()
        if len(faces) > 1:
            self.trouble = f"{len(faces)} faces were seen; only one person may be in front of the camera"
        for person in faces if len(faces) == 1 else ():
            self._number = person.number
            self.trouble = "the face is too small or was not seen for long enough; come nearer and look at the camera"
            if person.likeness is not None and len(self.taken) < LOOKS:
                self.taken.append(person.likeness)
        if len(self.taken) >= LOOKS:
            self.enough.set()
