from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import pytest
from openrois_streaming.adaptation.rung import Rung, ladder
from openrois_streaming.errors import NoEncoder
from openrois_streaming.publish.encoder_limit import ENCODERS_LIMIT, EncoderLimit, within_limit

CODECS = ("video/H264", "video/VP8")


@dataclass(eq=False)
class Made:
    """A rendition of a source."""

    mime_type: str
    rung: Rung | None
    is_wanted: bool = False


class Source:
    """A source of 1280x720 pictures and its renditions."""

    def __init__(self, limit: int | EncoderLimit = ENCODERS_LIMIT) -> None:
        self.made: dict[tuple[str, int, int], Made] = {}
        self._limit = EncoderLimit(limit) if isinstance(limit, int) else limit
        self._limit.add_source(self.made.values)

    def ladder(self, codec: str, every: int = 1) -> list[Made]:
        rungs = ladder(1280, 720, 30.0, every=every)
        return [self.made.setdefault((codec, r.halvings, r.every), Made(codec, r)) for r in rungs]

    def have(self, codec: str, every: int = 1) -> tuple[Made, ...]:
        asked, first = self.ladder(codec, every), self.ladder(codec)[0]
        return self._limit.choose(asked, first, self.made.values())

    @property
    def running(self) -> int:
        return sum(each.is_wanted for each in self.made.values())


def test_where_there_is_room_everybody_has_what_they_ask_for() -> None:
    source = Source()
    assert list(source.have("video/H264", every=3)) == source.ladder("video/H264", every=3)


class Viewer:
    """A viewer that asks for one rendition, and goes where it is let whenever it looks, as `Downlink.tick` does."""

    def __init__(self, source: Source, codec: str = "video/H264", index: int = 0, every: int = 1) -> None:
        self.plays: Made | None = None
        self._source, self._codec, self._index, self._every = source, codec, index, every

    @property
    def asks_for(self) -> Made:
        return self._source.ladder(self._codec, self._every)[self._index]

    def look(self, others: Iterable["Viewer"]) -> None:
        """Choose anew; a rendition is wanted while a viewer plays it."""
        chosen = self._source.have(self._codec, self._every)[self._index]
        former, self.plays, chosen.is_wanted = self.plays, chosen, True
        if former is not None:
            former.is_wanted = any(each.plays is former for each in others)


def settled(viewers: Sequence[Viewer]) -> int:
    """Let all look until nothing changes; return how many are encoded then."""
    for _ in range(10):
        before = [each.plays for each in viewers]
        for each in viewers:
            each.look(viewers)
        if [each.plays for each in viewers] == before:
            return len({id(each.plays) for each in viewers})
    raise AssertionError("viewers change without end")


def test_whatever_viewers_ask_for_no_more_are_encoded_and_the_first_of_each_codec_always_fits() -> None:
    source = Source()
    viewers: list[Viewer] = []
    for codec in CODECS:
        for every in (8, 5, 4, 3, 2, 1):
            for index in (2, 1, 0):
                viewers.append(Viewer(source, codec, index, every))
                assert settled(viewers) <= ENCODERS_LIMIT
    assert source.running == ENCODERS_LIMIT
    for codec in CODECS:
        assert source.ladder(codec)[0].is_wanted
        assert source.have(codec)[0] is source.ladder(codec)[0]


def test_three_watched_sources_have_smaller_sizes_and_the_fourth_to_the_sixth_take_their_places() -> None:
    limit = EncoderLimit(6)
    sources = [Source(limit) for _ in range(7)]
    viewers = [Viewer(source, index=index) for source in sources[:3] for index in (0, 1)]
    assert settled(viewers) == 6
    assert all(each.plays is each.asks_for for each in viewers), "codecs and sources without viewers reserve nothing"
    for count, source in enumerate(sources[3:6], 1):
        viewers.append(Viewer(source))
        assert settled(viewers) == 6
        shared = [each for each in viewers if each.plays is not each.asks_for]
        assert len(shared) == count, "no more viewers share than places were needed"
        assert viewers[-1].plays is viewers[-1].asks_for
    with pytest.raises(NoEncoder, match="disconnect another stream, or raise max_encoders of the adapter"):
        sources[6].have("video/H264")
    del viewers[-1]
    sources[5].ladder("video/H264")[0].is_wanted = False
    assert settled(viewers) == 6
    assert len([each for each in viewers if each.plays is not each.asks_for]) == 2, "a place that is free is used again"


def test_of_the_sizes_of_a_source_the_one_between_gives_way_before_the_smallest() -> None:
    limit = EncoderLimit(3)
    one, two = Source(limit), Source(limit)
    large, between, small = viewers = [Viewer(one, index=index) for index in range(3)]
    assert settled(viewers) == 3
    between_every = Viewer(one, index=2, every=2)
    assert settled([*viewers, between_every]) == 3
    assert between_every.plays is small.plays
    other = Viewer(two, "video/VP8", index=1)
    assert settled([*viewers, between_every, other]) == 3
    assert other.plays is other.asks_for, "a source that was not watched begins with what suits its viewer"
    assert (large.plays, small.plays) == (large.asks_for, small.asks_for)
    assert between.plays in (large.plays, small.plays)


def test_the_largest_size_is_had_where_only_a_smaller_one_runs_and_all_encoders_are_in_use() -> None:
    limit = EncoderLimit(2)
    one, two = Source(limit), Source(limit)
    small, other = Viewer(one, index=2), Viewer(two)
    assert settled([small, other]) == 2
    large = Viewer(one)
    assert settled([small, other, large]) == 2
    assert large.plays is small.plays is large.asks_for


def test_viewer_beyond_the_limit_gets_the_nearest_running_rendition() -> None:
    source = Source(limit=2)
    full, half, quarter = source.ladder("video/H264")
    half.is_wanted = True
    slow = source.ladder("video/H264", every=8)[2]
    slow.is_wanted = True
    assert list(source.have("video/H264")) == [full, half, half], "the largest still fits"
    assert list(source.have("video/H264", every=2)) == [full, half, slow], "size and pace count alike"
    half.is_wanted, quarter.is_wanted = False, True
    assert list(source.have("video/H264")) == [full, full, quarter], "what runs is had"


def test_a_codec_that_finds_no_encoder_is_refused() -> None:
    source = Source(limit=1)
    source.have("video/H264")[0].is_wanted = True
    assert [each.rung for each in source.have("video/H264")] == [source.ladder("video/H264")[0].rung] * 3
    with pytest.raises(NoEncoder, match="all 1 encoders are in use, and none encodes video/VP8"):
        source.have("video/VP8")


def test_rendition_without_size_is_infinitely_far_and_gives_way_last() -> None:
    first, other = Made("video/VP8", None, is_wanted=True), Made("video/VP8", None)
    assert within_limit([other], first, [first], [[first]], 1) == (first,)
    other.is_wanted = True
    assert within_limit([other], first, [first, other], [[first, other]], 1) == (first,)


def test_sources_that_share_a_limit_have_their_first_renditions_and_together_no_more() -> None:
    limit = EncoderLimit(5)
    one, two = Source(limit), Source(limit)
    viewers = [Viewer(one, "video/H264", index, every) for every in (3, 2, 1) for index in (2, 1, 0)]
    assert settled(viewers) == 5
    for source in (two, one):
        for codec in CODECS:
            viewers.append(Viewer(source, codec))
            assert settled(viewers) == 5
            assert viewers[-1].plays is source.ladder(codec)[0]
    assert one.running == 3
    assert list(two.have("video/VP8", every=2)) == [two.ladder("video/VP8")[0]] * 3


def test_with_more_sources_than_encoders_the_last_one_is_refused() -> None:
    limit = EncoderLimit(2)
    sources = [Source(limit) for _ in range(3)]
    for source in sources[:2]:
        source.have("video/H264")[0].is_wanted = True
    with pytest.raises(NoEncoder, match="all 2 encoders are in use, and none encodes video/H264"):
        sources[2].have("video/H264")
    sources[0].made["video/H264", 0, 1].is_wanted = False
    assert sources[2].have("video/H264")[0] is sources[2].ladder("video/H264")[0]
