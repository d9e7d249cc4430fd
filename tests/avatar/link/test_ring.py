import fcntl
import os
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_avatar.link.media import Doorbell, PixelFormat
from openrois_avatar.link.messages import SLOT_HEAD, LinkError, RingPlace, VideoShape
from openrois_avatar.link.ring import SLOTS, Ring
from openrois_avatar.link.ring_writer import RingWriter

pytestmark = pytest.mark.extra(name="avatar")

SHAPE = VideoShape(4, 2, 30, "nv12")
PIXELS = bytes(range(12))


def bell(sequence: int, slot: int | None, width: int = 4, height: int = 2) -> Doorbell:
    assert slot is not None
    return Doorbell(sequence, 0, width, height, width, PixelFormat.NV12, slot)


@pytest.fixture
def ring() -> Iterator[Ring]:
    ring = Ring(SHAPE)
    yield ring
    ring.release()


@pytest.fixture
def writer(ring: Ring) -> RingWriter:
    return RingWriter(ring.place)


def write(writer: RingWriter, sequence: int, pixels: bytes = PIXELS) -> Doorbell:
    return bell(sequence, writer.write(sequence, memoryview(pixels)))


def test_written_picture_is_read_without_a_copy(ring: Ring, writer: RingWriter) -> None:
    rung = write(writer, 0)
    video = ring.picture(rung)
    assert video is not None
    assert bytes(video.pixels) == PIXELS
    assert ring.is_whole(rung)
    for number in range(1, SLOTS + 1):
        write(writer, number, bytes(12))
    assert bytes(video.pixels) == bytes(12)
    assert not ring.is_whole(rung)


def test_slots_are_written_in_turn(ring: Ring, writer: RingWriter) -> None:
    assert [write(writer, number).slot for number in range(SLOTS + 1)] == [*range(SLOTS), 0]


def test_a_picture_that_is_being_overwritten_is_none(ring: Ring, writer: RingWriter) -> None:
    rung = write(writer, 0)
    writer._locks[0] = 2 * SLOTS + 1
    assert ring.picture(rung) is None
    assert not ring.is_whole(rung)


def test_a_picture_that_was_overwritten_is_none(ring: Ring, writer: RingWriter) -> None:
    rung = write(writer, 0)
    for number in range(1, SLOTS + 1):
        write(writer, number)
    assert ring.picture(rung) is None
    assert ring.picture(bell(SLOTS, 0)) is not None


def test_the_sequence_may_wrap(ring: Ring, writer: RingWriter) -> None:
    assert ring.picture(write(writer, 2**64 - 1)) is not None
    assert ring.picture(write(writer, 2**64)) is not None


@pytest.mark.parametrize(
    ("rung", "named"),
    [
        (bell(0, SLOTS), "RING: slot 4 of 4; count them from 0"),
        (bell(0, 2**32 - 1), "RING: slot 4294967295 of 4"),
        (bell(0, 1), "picture 0 is not in slot 1: its lock word is 0 and should be 2; write the pixels"),
        (bell(7, 0), "picture 7 is not in slot 0: its lock word is 2 and should be 16"),
        (bell(0, 0, 64, 64), "6144 bytes of pixels do not fit a slot of 4096; send them as VIDEO"),
    ],
)
def test_a_doorbell_that_cannot_be_true_is_a_fault(ring: Ring, writer: RingWriter, rung: Doorbell, named: str) -> None:
    write(writer, 0)
    with pytest.raises(LinkError, match=named):
        ring.picture(rung)


@given(
    st.lists(st.tuples(st.integers(0, SLOTS - 1), st.integers(0, 2**64 - 1)), max_size=4),
    st.integers(0, 2**64 - 1),
    st.integers(0, 2**32 - 1) | st.integers(0, SLOTS - 1),
    st.sampled_from([(4, 2), (60, 60), (16_384, 2)]),
)
@settings(max_examples=60, deadline=None)
def test_arbitrary_contents_raise_nothing_else(
    locks: list[tuple[int, int]], sequence: int, slot: int, size: tuple[int, int]
) -> None:
    ring = Ring(SHAPE)
    try:
        writer = RingWriter(ring.place)
        for place, word in locks:
            writer._locks[place * ring.place.slot_bytes // 8] = word
        rung = bell(sequence, slot, *size)
        try:
            video = ring.picture(rung)
        except LinkError:
            return
        assert (video is not None) is ring.is_whole(rung)
    finally:
        ring.release()


def test_oversized_picture_is_not_written(writer: RingWriter, ring: Ring) -> None:
    assert writer.write(0, memoryview(bytes(ring.place.slot_bytes - SLOT_HEAD))) == 0
    assert writer.write(1, memoryview(bytes(ring.place.slot_bytes - SLOT_HEAD + 1))) is None
    assert writer.write(2, memoryview(PIXELS)) == 1


@pytest.mark.parametrize("pixel_format", ["bgra", "i420", "nv12"])
def test_a_slot_has_room_for_rows_as_graphics_cards_pad_them(pixel_format: str) -> None:
    ring = Ring(VideoShape(1366, 768, 30, pixel_format))
    rows = 768 if pixel_format == "bgra" else 768 * 3 // 2
    row = 1366 * 4 if pixel_format == "bgra" else 1366
    assert ring.place.slot_bytes >= SLOT_HEAD + rows * (row + -row % 256)
    assert ring.place.slot_bytes % 4096 == 0
    ring.release()


def test_pictures_that_are_too_large_get_no_ring() -> None:
    with pytest.raises(LinkError, match="over the limit"):
        Ring(VideoShape(16_384, 16_384, 30))


def test_ring_is_private_and_cannot_be_shrunk_by_an_engine(ring: Ring) -> None:
    path = Path(ring.place.path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    file = os.open(path, os.O_RDWR)
    try:
        for size in (0, 1 << 24):
            with pytest.raises(PermissionError):
                os.ftruncate(file, size)
        with pytest.raises(PermissionError):
            fcntl.fcntl(file, fcntl.F_ADD_SEALS, fcntl.F_SEAL_WRITE)
    finally:
        os.close(file)


def test_released_it_can_no_longer_be_opened_and_what_is_read_of_it_stays(ring: Ring, writer: RingWriter) -> None:
    video = ring.picture(write(writer, 0))
    assert video is not None
    ring.release()
    ring.release()
    assert not Path(ring.place.path).exists()
    assert bytes(video.pixels) == PIXELS


@pytest.mark.parametrize("place", [RingPlace("no/such/file", 2, 4096), RingPlace("", 2, 4096)])
def test_a_ring_that_cannot_be_opened_is_named(place: RingPlace) -> None:
    with pytest.raises(LinkError, match="the ring cannot be opened"):
        RingWriter(place)


def test_a_ring_that_is_smaller_than_was_said_is_refused(tmp_path: Path) -> None:
    (tmp_path / "ring").write_bytes(bytes(4096))
    with pytest.raises(LinkError, match="the ring cannot be opened"):
        RingWriter(RingPlace(str(tmp_path / "ring"), 2, 4096))


def test_missing_memory_for_a_ring_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> int:
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr(os, "ftruncate", none)
    with pytest.raises(LinkError, match=r"no memory for a ring: .*; pictures go through the socket"):
        Ring(SHAPE)
    monkeypatch.setattr(os, "memfd_create", none)
    with pytest.raises(LinkError, match=r"no memory for a ring: .*; pictures go through the socket"):
        Ring(SHAPE)
    monkeypatch.setattr(sys, "platform", "darwin")
    with pytest.raises(LinkError, match="needs Linux"):
        Ring(SHAPE)
