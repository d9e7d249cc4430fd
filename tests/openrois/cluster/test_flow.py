"""Numbers and credit: all arrives in order, or the fault is noticed; what waits has a bound."""

import random
from collections import deque

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.cluster.flow import MESSAGE_COST, Receiving, Sending
from openrois.cluster.frames import Frame, FrameFault, Kind, pack_frame, pack_texts, parse_frame

pytestmark = pytest.mark.extra(name="cluster")
WINDOW = 4096
MOST = 20_000
TEXTS = st.lists(st.integers(0, 9000).map(lambda length: bytes([length % 251]) * length), max_size=30)


def frame(kind: Kind, body: bytes = b"", number: int = 0) -> Frame:
    return Frame(kind, number, body)


class Way:
    """A direction with both of its ends, and frames on their way."""

    def __init__(self) -> None:
        self.sending = Sending(WINDOW, 1000)
        self.receiving = Receiving(WINDOW, MOST)
        self.waiting: deque[tuple[Kind, bytes, int]] = deque()
        self.under_way: deque[bytes] = deque()
        self.received: list[bytes] = []

    def send(self) -> bool:
        if not self.waiting or not self.sending.allows(self.waiting[0][2]):
            return False
        self.under_way.append(self.sending.frame(*self.waiting.popleft()))
        return True

    def arrive(self) -> bool:
        if not self.under_way:
            return False
        came = parse_frame(self.under_way.popleft())
        self.receiving.count(came.number)
        self.receiving.put(came)
        assert self.receiving.held <= WINDOW + MOST
        self.grant()
        return True

    def receive(self) -> bool:
        if not len(self.receiving):
            return False
        self.received.append(bytes(self.receiving.pop()))
        self.grant()
        return True

    def grant(self) -> None:
        if (granted := self.receiving.next_grant()) is not None:
            self.sending.grant(granted)


@given(TEXTS, st.booleans(), st.randoms(use_true_random=False))
def test_all_messages_arrive_in_order_however_the_two_ends_take_turns(
    texts: list[bytes], together: bool, chance: random.Random
) -> None:
    way = Way()
    if together:
        way.waiting.extend(way.sending.batches(texts))
    else:
        way.waiting.extend(each for text in texts for each in way.sending.pieces(text))
    steps = [way.send, way.arrive, way.receive]
    while len(way.received) < len(texts):
        chance.shuffle(steps)
        assert any(step() for step in steps), "all wait for each other"
    assert way.received == texts
    assert way.receiving.held == 0


@given(TEXTS)
def test_a_receiver_that_does_not_read_holds_a_window_and_one_message_at_most(texts: list[bytes]) -> None:
    way = Way()
    way.waiting.extend(each for text in texts * 5 for each in way.sending.pieces(text))
    while way.send() or way.arrive():
        pass
    assert way.receiving.held <= WINDOW + MOST
    assert len(way.receiving) <= WINDOW // MESSAGE_COST


def test_messages_share_frames() -> None:
    sending = Sending(1 << 20, 1 << 19)
    made = list(sending.batches([b"a", b"bc", b"x" * 70_000, b"d"]))
    assert [(kind, cost) for kind, _, cost in made] == [
        (Kind.TEXTS, 3 + 2 * MESSAGE_COST),
        (Kind.TEXT, 70_000 + MESSAGE_COST),
        (Kind.TEXT, 1 + MESSAGE_COST),
    ]
    assert made[0][1] == pack_texts([b"a", b"bc"])
    full = list(sending.batches([b"x" * 30_000] * 4))
    assert [kind for kind, _, _ in full] == [Kind.TEXTS, Kind.TEXTS]
    assert list(sending.batches([])) == []


def test_a_long_message_goes_in_pieces() -> None:
    sending = Sending(1 << 20, 10)
    assert list(sending.pieces(b"x" * 25)) == [
        (Kind.PART, b"x" * 10, 10 + MESSAGE_COST),
        (Kind.PART, b"x" * 10, 10 + MESSAGE_COST),
        (Kind.LAST, b"x" * 5, 5 + MESSAGE_COST),
    ]
    assert list(sending.pieces(b"x" * 10)) == [(Kind.TEXT, b"x" * 10, 10 + MESSAGE_COST)]
    assert sending.frame(Kind.TEXT, b"a") == pack_frame(Kind.TEXT, 0, b"a")
    assert sending.frame(Kind.TEXT, b"b") == pack_frame(Kind.TEXT, 1, b"b")


@pytest.mark.parametrize("number", [0, 1, 3, 2**64 - 1])
def test_a_gap_a_duplicate_and_a_wrong_order_are_faults(number: int) -> None:
    receiving = Receiving(WINDOW, MOST)
    receiving.count(0)
    receiving.count(1)
    with pytest.raises(FrameFault, match="where 2 was due"):
        receiving.count(number)


@pytest.mark.parametrize(
    "frames",
    [
        [frame(Kind.LAST, b"x")],
        [frame(Kind.PART, b"x"), frame(Kind.TEXT, b"y")],
        [frame(Kind.PART, b"x"), frame(Kind.TEXTS, pack_texts([b"y"]))],
        [frame(Kind.TEXTS, b"")],
        [frame(Kind.ALIVE)],
        [frame(Kind.TEXT, b"x" * WINDOW)],
        [frame(Kind.TEXTS, pack_texts([b""] * (WINDOW // MESSAGE_COST + 1)))],
    ],
)
def test_what_may_not_come_is_a_fault(frames: list[Frame]) -> None:
    receiving = Receiving(WINDOW, MOST)
    for each in frames[:-1]:
        receiving.put(each)
    with pytest.raises(FrameFault):
        receiving.put(frames[-1])


def test_a_message_that_is_too_long_is_said_to_be() -> None:
    for last in (Kind.PART, Kind.LAST):
        receiving = Receiving(WINDOW, 3000)
        receiving.put(frame(Kind.PART, b"x" * 2000))
        with pytest.raises(OverflowError, match="at most 3000 bytes"):
            receiving.put(frame(last, b"x" * 1001))
    with pytest.raises(OverflowError):
        Receiving(WINDOW, 3000).put(frame(Kind.TEXT, b"x" * 3001))


def test_credit_only_grows() -> None:
    sending = Sending(WINDOW, 1000)
    sending.grant(WINDOW)
    with pytest.raises(FrameFault, match="taken back"):
        sending.grant(WINDOW - 1)


def test_credit_is_told_when_it_is_worth_a_frame() -> None:
    receiving = Receiving(WINDOW, MOST)
    assert receiving.next_grant() is None
    receiving.put(frame(Kind.TEXT, b"x" * (WINDOW // 4 - MESSAGE_COST)))
    assert receiving.next_grant() is None
    receiving.pop()
    assert receiving.next_grant() == WINDOW + WINDOW // 4
    assert receiving.next_grant() is None


def test_what_is_discarded_is_not_received() -> None:
    receiving = Receiving(WINDOW, MOST)
    receiving.put(frame(Kind.TEXT, b"a"))
    receiving.put(frame(Kind.PART, b"b"))
    receiving.discard()
    assert (len(receiving), receiving.held) == (0, 0)


@given(st.lists(st.tuples(st.sampled_from(list(Kind)), st.binary(max_size=2000)), max_size=50))
def test_whatever_comes_is_taken_in_or_is_a_fault(came: list[tuple[Kind, bytes]]) -> None:
    receiving = Receiving(WINDOW, MOST)
    for number, (kind, body) in enumerate(came):
        receiving.count(number)
        try:
            receiving.put(frame(kind, body))
        except (FrameFault, OverflowError):
            break
        assert receiving.held <= WINDOW + MOST
