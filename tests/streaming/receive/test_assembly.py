from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.receive import assembly
from openrois_streaming.receive.assembly import PACKETS_LIMIT, Picture, Request, VideoAssembly, VideoPacket
from openrois_streaming.receive.payloads import MalformedPayload, Piece

from tests.support.steps import lines_run

MALFORMED = b"\xff"
BEGINS, KEY, OPENS_KEY = 1, 2, 4
NOTHING = Request((), key_frame=False)


def piece_of(payload: bytes) -> Piece:
    """What a payload of this test holds: its first byte says which piece it is."""
    if payload == MALFORMED:
        raise MalformedPayload("spoilt")
    flags = payload[0]
    return Piece(payload[1:], bool(flags & BEGINS), bool(flags & KEY), bool(flags & OPENS_KEY))


def picture(number: int, first: int, packets: int = 3, *, key: bool = False) -> list[VideoPacket]:
    """Picture `number`, of `packets` packets from sequence number `first` on."""
    flags = BEGINS | (KEY | OPENS_KEY if key else 0)
    return [
        VideoPacket(
            first + index,
            3000 * number,
            index == packets - 1,
            bytes([0 if index else flags]) + b"%d.%d " % (number, index),
        )
        for index in range(packets)
    ]


def data(number: int, packets: int = 3) -> bytes:
    return b"".join(b"%d.%d " % (number, index) for index in range(packets))


def whole(number: int, *, key: bool = False, decodable: bool = True) -> Picture:
    return Picture(data(number), 3000 * number, key, decodable)


class Stream:
    """Feeds an assembly and keeps what comes out."""

    def __init__(self, *, watched: bool = True) -> None:
        self.assembly = VideoAssembly(piece_of)
        self.assembly.watched = watched
        self.pictures: list[Picture] = []
        self.requests: list[Request] = []
        self.now = 100.0

    def feed(self, *packets: VideoPacket, after: float = 0.0) -> "Stream":
        for packet in packets:
            self.now += after
            self.pictures += self.assembly.add(packet, self.now)
            self.attend()
        return self

    def attend(self) -> None:
        pictures, request = self.assembly.check_deadlines(self.now)
        self.pictures += pictures
        if request != NOTHING:
            self.requests.append(request)

    def wait(self, seconds: float) -> None:
        """Let time pass, as a caller does that attends when it is due."""
        end = self.now + seconds
        while (at := self.assembly.next_at) is not None and at <= end:
            self.now = max(self.now, at) + 1e-6
            self.attend()
        self.now = max(self.now, end)

    @property
    def asked_for(self) -> list[int]:
        return [sequence for request in self.requests for sequence in request.packets]

    @property
    def key_frames_asked(self) -> int:
        return sum(request.key_frame for request in self.requests)

    def started(self) -> "Stream":
        """A stream whose key frame has arrived, up to sequence number 12, picture 0."""
        self.feed(*picture(0, 10, key=True))
        assert self.pictures == [whole(0, key=True)]
        self.pictures.clear()
        self.requests.clear()
        return self


class TestOrder:
    def test_a_picture_comes_with_its_last_packet(self) -> None:
        stream = Stream()
        first, second, last = picture(0, 10, key=True)
        assert stream.feed(first, second).pictures == []
        assert stream.feed(last).pictures == [whole(0, key=True)]

    def test_packets_in_another_order(self) -> None:
        stream = Stream().started()
        a, b, c = picture(1, 13)
        d, e, f = picture(2, 16)
        stream.feed(b, f, a, e)
        assert stream.pictures == []
        stream.feed(c)
        assert stream.pictures == [whole(1)]
        stream.feed(d)
        assert stream.pictures == [whole(1), whole(2)]

    def test_duplicate_packet_is_counted_and_ignored(self) -> None:
        stream = Stream().started()
        a, b, c = picture(1, 13)
        stream.feed(a, a, b, c, b)
        assert stream.pictures == [whole(1)]
        assert stream.assembly.duplicates == 2

    def test_without_a_marker_a_picture_ends_where_another_begins(self) -> None:
        stream = Stream().started()
        unmarked = [packet._replace(marker=False) for packet in picture(1, 13)]
        assert stream.feed(*unmarked).pictures == []
        assert stream.feed(*picture(2, 16)).pictures == [whole(1), whole(2)]

    def test_padding_is_no_picture(self) -> None:
        stream = Stream().started()
        padding = VideoPacket(13, 0, marker=False, payload=b"")
        stream.feed(padding, *picture(1, 14), VideoPacket(17, 3000, marker=True, payload=b""), *picture(2, 18))
        assert stream.pictures == [whole(1), whole(2)]

    @given(st.permutations(range(24)), st.integers(0, 5))
    def test_any_order_gives_the_same(self, order: list[int], doubled: int) -> None:
        packets = [packet for number in range(1, 9) for packet in picture(number, 10 + 3 * number)]
        stream = Stream().started()
        for index in order:
            stream.feed(*[packets[index]] * (2 if index % 6 == doubled else 1))
        assert stream.pictures == [whole(number) for number in range(1, 9)]


class TestLosses:
    def test_a_gap_is_asked_for_at_once_and_again(self) -> None:
        stream = Stream().started()
        a, _, c = picture(1, 13)
        stream.feed(a, c)
        assert stream.requests == [Request((14,), key_frame=False)]
        stream.wait(0.14)
        assert stream.asked_for == [14], "the answer may still be on its way"
        stream.wait(0.02)
        assert stream.asked_for == [14, 14]

    def test_picture_repaired_in_time_is_released_in_order(self) -> None:
        stream = Stream().started()
        a, b, c = picture(1, 13)
        stream.feed(a, c, *picture(2, 16))
        assert stream.pictures == []
        stream.wait(0.03)
        stream.feed(b)
        assert stream.pictures == [whole(1), whole(2)]
        assert stream.key_frames_asked == 0
        assert 0.02 < stream.assembly.round_trip.seconds < 0.04

    def test_after_the_patience_a_key_frame_is_asked_for(self) -> None:
        stream = Stream().started()
        a, _, c = picture(1, 13)
        stream.feed(a, c)
        stream.wait(0.195)
        assert stream.key_frames_asked == 0
        stream.wait(0.01)
        assert stream.key_frames_asked == 1
        assert stream.assembly.given_up == 1

    def test_nothing_is_decoded_until_the_key_frame(self) -> None:
        stream = Stream().started()
        a, _, c = picture(1, 13)
        stream.feed(a, c, *picture(2, 16))
        stream.wait(0.3)
        stream.feed(*picture(3, 19), *picture(4, 22, key=True), *picture(5, 25))
        # The rest of picture 1 shows nothing, and picture 2 refers to it.
        assert [(each.timestamp // 3000, each.decodable) for each in stream.pictures] == [
            (2, False),
            (3, False),
            (4, True),
            (5, True),
        ]

    def test_a_key_frame_is_asked_for_again_while_none_comes(self) -> None:
        stream = Stream()
        for number in range(31):
            stream.feed(*picture(number, 10 + 3 * number))
            stream.wait(1 / 30)
        assert 3 <= stream.key_frames_asked <= 4
        assert not any(each.decodable for each in stream.pictures)

    def test_a_whole_key_frame_behind_a_gap_is_not_waited_for(self) -> None:
        stream = Stream().started()
        a, _, c = picture(1, 13)
        stream.feed(a, c, *picture(2, 16, key=True))
        assert stream.pictures == [whole(2, key=True)]
        stream.wait(0.5)
        assert stream.asked_for == [14]

    def test_a_key_frame_with_a_gap_is_repaired(self) -> None:
        stream = Stream().started()
        a, _, c = picture(1, 13)
        d, e, f = picture(2, 16, key=True)
        stream.feed(a, c, d, f, *picture(3, 19))
        assert stream.asked_for == [14, 17]
        stream.feed(e)
        assert stream.pictures == [whole(2, key=True), whole(3)]

    def test_a_key_frame_without_its_end_is_none(self) -> None:
        stream = Stream().started()
        a, _, c = picture(1, 13)
        stream.feed(a, c, *picture(2, 16, key=True)[:2], *picture(3, 19))
        assert stream.pictures == []

    def test_the_rest_of_a_key_frame_is_none(self) -> None:
        stream = Stream()
        rest = [packet._replace(payload=bytes([KEY]) + b"slice") for packet in picture(0, 10, key=True)[1:]]
        assert stream.feed(*rest).pictures == []
        assert stream.feed(*picture(1, 13)).pictures == [whole(1, decodable=False)]

    def test_a_beginning_that_is_lost(self) -> None:
        stream = Stream().started()
        stream.feed(*picture(1, 13)[1:], *picture(2, 16))
        stream.wait(0.3)
        assert [each.timestamp // 3000 for each in stream.pictures] == [2]
        assert stream.key_frames_asked == 1

    def test_a_spoilt_packet_breaks_the_chain(self) -> None:
        stream = Stream().started()
        a, b, c = picture(1, 13)
        stream.feed(a, b._replace(payload=MALFORMED), c, *picture(2, 16))
        assert stream.pictures == [whole(2, decodable=False)]
        assert stream.key_frames_asked == 1

    def test_a_picture_that_does_not_begin_breaks_the_chain(self) -> None:
        stream = Stream().started()
        stream.feed(VideoPacket(13, 3000, marker=True, payload=b"\x00rest"))
        assert stream.pictures == []
        assert stream.key_frames_asked == 1

    def test_a_silent_sender_is_not_asked(self) -> None:
        stream = Stream().started()
        a, _, c = picture(1, 13)
        stream.feed(a, c)
        stream.wait(10)
        asked = len(stream.requests)
        assert asked <= 12
        assert stream.assembly.next_at is None
        stream.attend()
        assert len(stream.requests) == asked

    def test_the_path_that_is_slow_gets_more_patience(self) -> None:
        stream = Stream().started()
        stream.assembly.round_trip.measure(0.4)
        a, _, c = picture(1, 13)
        stream.feed(a, c)
        stream.wait(0.19)
        assert stream.key_frames_asked == 0
        stream.wait(0.02)
        assert stream.key_frames_asked == 1

    def test_a_key_frame_that_nothing_is_shown_without_is_waited_for_while_it_is_being_repaired(self) -> None:
        stream, key = Stream(), picture(0, 10, 40, key=True)
        stream.feed(key[0], key[-1], *picture(1, 50))
        assert stream.asked_for == list(range(11, 43)), "no more at a time than a slow path has room for"
        for packet in key[1:20]:
            stream.wait(0.15)
            stream.feed(packet)
        assert (stream.key_frames_asked, stream.pictures) == (0, [])
        stream.feed(*key[20:])
        assert [each.decodable for each in stream.pictures] == [True, True]
        assert stream.key_frames_asked == 0

    def test_a_key_frame_that_is_not_repaired_any_more_is_given_up(self) -> None:
        stream, key = Stream(), picture(0, 10, 40, key=True)
        stream.feed(*key[:5], *key[6:])
        stream.wait(0.29)
        assert stream.key_frames_asked == 0
        stream.wait(0.71)
        assert stream.assembly.given_up == 1
        assert 1 <= stream.key_frames_asked <= 2

    def test_a_key_frame_that_takes_too_long_is_given_up(self) -> None:
        stream, key = Stream(), picture(0, 10, 60, key=True)
        stream.feed(key[0], key[-1])
        for packet in key[1:40]:
            stream.wait(0.1)
            stream.feed(packet)
        assert (stream.key_frames_asked, stream.assembly.given_up) == (0, 0)
        stream.feed(*key[41:51], after=0.1)
        assert stream.assembly.given_up > 0
        assert 1 <= stream.key_frames_asked <= 2

    def test_key_frames_that_do_not_come_are_asked_for_less_and_less(self) -> None:
        stream = Stream()
        for number in range(300):
            stream.feed(*picture(number, 10 + 3 * number))
            stream.wait(1 / 30)
        assert stream.key_frames_asked == 7, "at 0, 0.3, 0.9, 2.1, 4.5, 6.9 and 9.3 s"


class TestBounds:
    def test_too_much_that_is_not_whole_is_thrown_away(self) -> None:
        stream = Stream().started()
        endless = [VideoPacket(13 + index, 3000, marker=False, payload=b"\x01x") for index in range(PACKETS_LIMIT + 1)]
        stream.feed(*endless)
        assert stream.key_frames_asked >= 1
        following = 14 + PACKETS_LIMIT
        stream.feed(*picture(2, following, key=True))
        assert stream.pictures[-1] == whole(2, key=True)

    def test_too_many_losses_are_not_repaired(self) -> None:
        stream = Stream().started()
        stream.feed(*picture(1, 600), *picture(2, 603, key=True))
        assert stream.pictures == [whole(2, key=True)]
        assert len(stream.asked_for) <= 600

    def test_a_leap_is_a_new_beginning(self) -> None:
        stream = Stream().started()
        stream.feed(*picture(1, 5000, key=True), *picture(2, 20, key=True))
        assert stream.pictures == [whole(1, key=True), whole(2, key=True)]
        assert stream.asked_for == []

    @given(
        st.lists(
            st.builds(
                VideoPacket,
                st.integers(0, 2000),
                st.integers(0, 5),
                st.booleans(),
                st.sampled_from([b"", MALFORMED, b"\x00a", b"\x01b", b"\x03c", b"\x07d"]),
            ),
            max_size=80,
        )
    )
    def test_anything_is_survived(self, packets: list[VideoPacket]) -> None:
        stream = Stream()
        decodable = False
        for packet in packets:
            stream.feed(packet, after=0.01)
        stream.wait(1)
        for each in stream.pictures:
            assert each.decodable or not each.key_frame
            decodable |= each.key_frame
            assert decodable or not each.decodable


class TestWatching:
    def test_unwatched_nothing_is_asked_for_and_nothing_waited_for(self) -> None:
        stream = Stream(watched=False)
        stream.feed(*picture(0, 10), *picture(1, 13)[:2], *picture(2, 16))
        assert stream.requests == []
        assert stream.assembly.next_at is None
        assert [each.timestamp // 3000 for each in stream.pictures] == [0, 2]

    def test_key_frame_is_requested_when_watching_begins(self) -> None:
        stream = Stream(watched=False)
        stream.feed(*picture(0, 10, key=True), *picture(1, 13))
        stream.assembly.watched = True
        stream.feed(*picture(2, 16))
        assert stream.key_frames_asked == 1
        assert [each.decodable for each in stream.pictures] == [True, True, False]

    def test_before_anything_came_nothing_is_asked_for(self) -> None:
        stream = Stream()
        stream.attend()
        assert stream.assembly.watched
        assert stream.requests == []

    def test_a_pause_leaves_nothing_behind(self) -> None:
        stream = Stream().started()
        a, _, c = picture(1, 13)
        stream.feed(a, c)
        stream.assembly.pause()
        stream.requests.clear()
        stream.feed(*picture(9, 40), *picture(10, 43, key=True))
        assert stream.asked_for == []
        assert stream.pictures[-1] == whole(10, key=True)


def test_key_frames_behind_a_gap_that_begin_again_and_again_take_little_work() -> None:
    stream = Stream().feed(*picture(0, 0, key=True))
    opening = bytes([BEGINS | OPENS_KEY])
    hostile = [VideoPacket(4 + index, 3000, False, opening) for index in range(300)]
    assert lines_run(lambda: stream.feed(*hostile), assembly) < 50 * 300 * 300
    assert stream.pictures == [whole(0, key=True)]


def test_a_key_frame_behind_a_gap_is_whole_only_without_a_gap_of_its_own_and_in_one_picture() -> None:
    first, second, third = picture(2, 10, 4, key=True), picture(3, 14, key=True), picture(4, 17, key=True)
    stream = Stream().feed(*picture(0, 0, key=True), first[0], first[1], first[3])
    stream.feed(second[0], third[0], third[1])
    assert stream.pictures == [whole(0, key=True)]
    assert stream.feed(third[2]).pictures[1:] == [whole(4, key=True)]
