import itertools

from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.reference_chain import REPEAT_REQUEST, ReferenceChain

from tests.support.viewing import frame


def admitted(frames: list[EncodedFrame], kind: str = "video") -> list[int]:
    chain = ReferenceChain(kind)
    return [each.sequence for each in frames if chain.admits(each)]


def test_nothing_is_of_use_before_a_key_frame() -> None:
    assert admitted([frame(1), frame(2), frame(3, keyframe=True), frame(4)]) == [3, 4]


def test_after_a_gap_only_a_key_frame_goes_on() -> None:
    frames = [frame(1, keyframe=True), frame(2), frame(4), frame(5), frame(8, keyframe=True), frame(9)]
    assert admitted(frames) == [1, 2, 8, 9]


def test_sound_goes_on_after_a_gap() -> None:
    assert admitted([frame(1), frame(5), frame(6)], "audio") == [1, 5, 6]


def test_a_key_frame_is_asked_for_once_and_then_once_a_second() -> None:
    chain = ReferenceChain("video")
    chain.admits(frame(0, keyframe=True))
    lost = [frame(number) for number in range(2, 100)]
    asked = [each.captured_at for each in lost if not chain.admits(each) and chain.should_ask(each)]
    assert asked[0] == lost[0].captured_at
    assert [later - earlier >= REPEAT_REQUEST for earlier, later in itertools.pairwise(asked)] == [True] * 3
    assert chain.admits(frame(100, keyframe=True))
    assert not chain.admits(frame(102))
    assert chain.should_ask(frame(102))


@given(st.lists(st.tuples(st.integers(0, 3), st.booleans()), max_size=40))
def test_admitted_frames_can_be_decoded(steps: list[tuple[int, bool]]) -> None:
    sequence, frames = 0, []
    for gap, keyframe in steps:
        sequence += 1 + gap
        frames.append(frame(sequence, keyframe=keyframe))
    keys = {each.sequence for each in frames if each.keyframe}
    previous = None
    for number in admitted(frames):
        assert number in keys or number - 1 == previous
        previous = number
