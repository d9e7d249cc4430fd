import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.input.messages import Key, State
from openrois_streaming.input.reader import AT_ONCE, MALFORMED_LIMIT, PER_SECOND, InputReader, Label

from tests.support.clock import Clock

STATE, KEY = '{"seq": 1, "t": 2}', '{"seq": 1, "t": 2, "event": "key", "code": "KeyW", "down": true}'


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def reader(clock: Clock) -> InputReader:
    return InputReader(clock)


def test_each_channel_has_its_messages(reader: InputReader) -> None:
    assert reader.read("input", STATE) == State(1, 2.0)
    assert reader.read("control", KEY) == Key(1, 2.0, "KeyW", True)
    assert reader.read("control", STATE) is None
    assert (reader.figures.read, reader.figures.malformed, reader.last_fault.partition(":")[0]) == (2, 1, "event")


@pytest.mark.parametrize("data", [b"{}", STATE + " " * 1024, '{"seq": 1, "t": 2, "x": "' + "ä" * 500 + '"}', "\ud800"])
def test_binary_or_too_long_messages_are_malformed(reader: InputReader, data: str | bytes) -> None:
    assert reader.read("input", data) is None
    assert reader.figures.malformed == 1


def test_after_many_malformed_ones_nothing_is_read(reader: InputReader) -> None:
    for _ in range(MALFORMED_LIMIT - 1):
        assert reader.read("input", "") is None
    assert reader.read("input", STATE) is not None
    assert not reader.is_cut
    reader.read("input", "")
    assert reader.is_cut
    assert reader.read("input", STATE) is None
    assert reader.figures.read == 1


def test_too_many_are_counted(reader: InputReader, clock: Clock) -> None:
    read = [reader.read("input", STATE) is not None for _ in range(AT_ONCE + 10)]
    assert (sum(read), reader.figures.excess) == (AT_ONCE, 10)
    clock.now += 5 / PER_SECOND
    assert [reader.read("input", STATE) is not None for _ in range(6)] == [True] * 5 + [False]


@given(st.sampled_from(["input", "control"]), st.text(max_size=1100) | st.binary(max_size=1100))
def test_whatever_comes_is_counted(label: Label, data: str | bytes) -> None:
    reader = InputReader(Clock())
    message = reader.read(label, data)
    assert (message is not None, reader.figures.read) == (reader.figures.malformed == 0, 1 - reader.figures.malformed)
