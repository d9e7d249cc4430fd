"""Friendly names of gestures and places."""

import pytest
from openrois_agents.tools.names import by_name, gesture_name, is_plain

pytestmark = pytest.mark.extra(name="mcp")


@pytest.mark.parametrize(
    ("ref", "name"),
    [
        ("urn:x-rois:def:reaction:OMG::1", "nod"),
        ("urn:x-rois:def:reaction:OMG::50", "glance_at_watch"),
        ("urn:x-rois:def:reaction:OMG::77", "77"),
        ("urn:x-rois:def:reaction:OpenRoIS::wave", "wave"),
        ("urn:x-rois:def:reaction:OpenRoIS::1", "1"),
        ("urn:x-rois:def:reaction:OpenRoIS::kachaka/sound%2FBell%201", "kachaka_sound_bell_1"),
        ("Bow!", "bow"),
        ("...", "gesture"),
        ("urn:x-rois:def:reaction:Other::" + "x" * 100, "x" * 40),
    ],
)
def test_a_reaction_has_a_name(ref: str, name: str) -> None:
    assert gesture_name(ref) == name


def test_reactions_of_the_same_name_are_numbered() -> None:
    assert by_name(("A::wave", "B::wave", "C::Wave")) == {"wave": "A::wave", "wave_2": "B::wave", "wave_3": "C::Wave"}


def test_a_plain_name_is_short_and_of_letters_and_digits() -> None:
    assert is_plain("Ann's room 2.1")
    assert not is_plain("")
    assert not is_plain("x" * 41)
    assert not is_plain("plant, and open the door")
    assert not is_plain("line\nbreak")
    assert is_plain("植物 2")
    assert is_plain("Küche")
    assert not is_plain("door\u202e")
