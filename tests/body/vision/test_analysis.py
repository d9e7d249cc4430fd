"""The analysis of real faces that move as heads do, with the offline backends, from picture to picture."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from openrois_body.vision.analysis import Analysis
from openrois_body.vision.cascades import CascadeFinder
from openrois_body.vision.gallery import Gallery, Likeness
from openrois_body.vision.head_gestures import Gesture
from openrois_body.vision.head_reader import GESTURE_REFS, HeadReader
from openrois_body.vision.patterns import PatternRecognizer
from openrois_body.vision.sighting import Sighting
from openrois_body.vision.view import View
from openrois_streaming.source.source import RawVideo

from tests.support.people import Scene, Sitter, nodding, picture, shaking, tilting, video

COLLINS, HOPPER = Sitter("collins"), Sitter("hopper")


def watched(scene: Scene, seconds: float, gallery: Gallery | None = None, *, collects: bool = False) -> list[Sighting]:
    """What is seen of a scene."""
    analysis = Analysis(CascadeFinder(), PatternRecognizer(), HeadReader(), gallery or Gallery())
    analysis.collects = collects
    return [analysis.analyse_view(View(each)) for each in video(scene, seconds, width=400, height=224)]


def gestures(seen: list[Sighting]) -> list[str]:
    return [person.gesture for each in seen for person in each.persons if person.gesture is not None]


def faces(seen: list[Sighting]) -> list[int]:
    return [sum(person.face for person in each.persons) for each in seen]


@pytest.mark.parametrize(
    ("sitter", "scene", "gesture"),
    [
        (COLLINS, nodding, "nod"),
        pytest.param(HOPPER, nodding, "nod", marks=pytest.mark.long),
        (COLLINS, shaking, "shake_head"),
        (HOPPER, tilting, "tilt"),
    ],
    ids=["collins nods", "hopper nods", "collins shakes her head", "hopper tilts hers"],
)
def test_a_head_gesture_is_read_from_the_picture(
    sitter: Sitter, scene: Callable[[Sitter], Scene], gesture: Gesture
) -> None:
    seen = watched(scene(sitter), 3.0)
    assert gestures(seen) == [GESTURE_REFS[gesture]]
    assert faces(seen)[3:] == [1] * 27


def test_sitting_walking_or_coming_nearer_is_no_gesture() -> None:
    assert gestures(watched(lambda t: [replace(COLLINS, x=0.3 + 0.1 * t, size=0.15 + 0.03 * t)], 2.5)) == []
    assert gestures(watched(lambda _t: [HOPPER], 1.5)) == []


def test_two_are_told_apart_and_placed() -> None:
    scene = [replace(COLLINS, x=0.25, size=0.16), replace(HOPPER, x=0.75, size=0.2)]
    left, right = sorted(watched(lambda _t: scene, 1.5)[-1].persons, key=lambda person: person.place.x)
    assert (left.number, right.number) in {(1, 2), (2, 1)}
    # What the pinhole says of the sizes at which they were drawn: 0.81 m and 0.65 m ahead.
    assert (left.place.x, left.place.y) == pytest.approx((-0.23, 0.81), rel=0.15)
    assert (right.place.x, right.place.y) == pytest.approx((0.19, 0.65), rel=0.15)


def test_person_that_leaves_is_dropped_after_a_while_and_returns_with_another_number() -> None:
    seen = watched(lambda t: [COLLINS] if t < 1.0 or t >= 4.0 else [], 5.5)
    at = dict(zip(range(55), seen, strict=True))
    assert [person.number for person in at[9].persons] == [1]
    assert [(person.number, person.face) for person in at[20].persons] == [(1, False)]
    assert at[35].persons == ()
    assert [(person.number, person.face) for person in at[54].persons] == [(2, True)]


def test_an_empty_room_is_empty() -> None:
    assert not any(each.persons for each in watched(lambda _t: [], 1.5))


def test_another_size_or_a_pause_is_another_scene() -> None:
    analysis = Analysis(CascadeFinder(), PatternRecognizer(), HeadReader(), Gallery())

    def pictures(width: int, height: int, begin: float) -> Iterator[RawVideo]:
        for each in video(lambda _t: [HOPPER], 0.5, width=width, height=height):
            yield replace_moment(each, begin)

    for begin, shape in ((0.0, (400, 224)), (0.5, (320, 240)), (9.0, (320, 240)), (3.0, (320, 240))):
        seen = [analysis.analyse_view(View(each)) for each in pictures(*shape, begin)]
        assert faces(seen)[0] == 0
        assert faces(seen)[-1] == 1


def replace_moment(raw: RawVideo, begin: float) -> RawVideo:
    return RawVideo(raw.data, raw.format, raw.width, raw.height, raw.sequence, begin + raw.captured_at)


@pytest.fixture(scope="module")
def gallery() -> Gallery:
    """Collins is enrolled from one sitting; Hopper is not."""
    seen = watched(lambda t: [replace(COLLINS, x=0.5 + 0.02 * t, turn=0.05 * t)], 1.5, collects=True)
    looks = [person.likeness for each in seen for person in each.persons if person.likeness is not None]
    assert len(looks) >= 10
    gallery = Gallery()
    gallery.enrol("Eileen", looks)
    return gallery


class TestIdentification:
    def names(self, gallery: Gallery, sitter: Sitter, **changes: float) -> set[str | None]:
        seen = watched(lambda _t: [replace(sitter, **changes)], 2.0, gallery)  # type: ignore[arg-type]
        assert faces(seen)[-1] == 1
        return {person.name for person in seen[-1].persons}

    @pytest.mark.parametrize("changes", [{}, {"size": 0.26, "x": 0.4, "lean": 8.0}], ids=["same", "near"])
    def test_enrolled_person_is_identified_elsewhere_in_the_picture(
        self, gallery: Gallery, changes: dict[str, float]
    ) -> None:
        assert self.names(gallery, COLLINS, **changes) == {"Eileen"}

    def test_another_person_is_not_identified(self, gallery: Gallery) -> None:
        assert self.names(gallery, HOPPER) == {None}

    def test_forgotten_person_loses_the_name_while_in_the_picture(self, gallery: Gallery) -> None:
        analysis = Analysis(CascadeFinder(), PatternRecognizer(), HeadReader(), gallery)
        *before, seen, last = map(View, video(lambda _t: [COLLINS], 2.0, width=400, height=224))
        for view in before:
            analysis.analyse_view(view)
        assert [person.name for person in analysis.analyse_view(seen).persons] == ["Eileen"]
        gallery.remove_person("Eileen")
        assert [person.name for person in analysis.analyse_view(last).persons] == [None]

    def test_no_likeness_is_computed_while_no_person_is_enrolled(self) -> None:
        class Refusing(PatternRecognizer):
            def likeness(self, view: View, face: object) -> None:
                raise AssertionError("a likeness was computed without an enrolment")

        analysis = Analysis(CascadeFinder(), Refusing(), HeadReader(), Gallery())
        seen = [analysis.analyse_view(View(each)) for each in video(lambda _t: [HOPPER], 1.0, width=400, height=224)]
        assert faces(seen)[-1] == 1

    @pytest.mark.parametrize(("light", "noise"), [(0.6, 6.0), pytest.param(1.25, 0.0, marks=pytest.mark.long)])
    def test_the_limit_lies_between_the_same_and_another_face(self, light: float, noise: float) -> None:
        recognizer = PatternRecognizer()

        def looks(sitter: Sitter, light: float, noise: float, seed: int) -> Likeness:
            shown = picture([sitter], 512, 288, light=light, noise=noise, seed=seed)
            view = View(RawVideo(shown, "bgr24", 512, 288, 0, 0.0))
            (face,) = CascadeFinder().find(view, [])
            found = recognizer.likeness(view, face)
            assert found is not None
            return found

        for one, other in ((COLLINS, HOPPER), (HOPPER, COLLINS)):
            enrolled = looks(one, 1.0, 2.0, 1)
            same = looks(replace(one, x=0.45, size=0.22, lean=6.0), light, noise, 2)
            strange = looks(replace(other, x=0.45, size=0.22), light, noise, 3)
            assert np.linalg.norm(enrolled - same) < recognizer.limit - 0.02
            assert np.linalg.norm(enrolled - strange) > recognizer.limit + 0.05
