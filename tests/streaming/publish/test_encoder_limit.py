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
        return self._limit.choose(asked, first, self.made.values(), len(CODECS))

    @property
    def running(self) -> int:
        return sum(each.is_wanted for each in self.made.values())


def test_where_there_is_room_everybody_has_what_they_ask_for() -> None:
    source = Source()
    assert list(source.have("video/H264", every=3)) == source.ladder("video/H264", every=3)


def test_whatever_viewers_ask_for_no_more_are_encoded_and_the_first_of_each_codec_always_fits() -> None:
    source = Source()
    for codec in CODECS:
        for every in (8, 5, 4, 3, 2, 1):
            for index in (2, 1, 0):
                source.have(codec, every)[index].is_wanted = True
    assert source.running == ENCODERS_LIMIT
    for codec in CODECS:
        assert source.ladder(codec)[0].is_wanted
        assert source.have(codec)[0] is source.ladder(codec)[0]


def test_viewer_beyond_the_limit_gets_the_nearest_running_rendition() -> None:
    source = Source(limit=4)
    full, half, quarter = source.ladder("video/H264")
    half.is_wanted = True
    slow = source.ladder("video/H264", every=8)[2]
    slow.is_wanted = True
    assert list(source.have("video/H264")) == [full, half, half], "the largest still fits"
    assert list(source.have("video/H264", every=2)) == [full, half, slow], "size and pace count alike"
    quarter.is_wanted = True
    assert list(source.have("video/H264")) == [full, half, quarter], "what runs is had"


def test_a_codec_that_finds_no_encoder_is_refused() -> None:
    source = Source(limit=1)
    source.have("video/H264")[0].is_wanted = True
    assert [each.rung for each in source.have("video/H264")] == [source.ladder("video/H264")[0].rung] * 3
    with pytest.raises(NoEncoder, match="all 1 encoders are in use, and none encodes video/VP8"):
        source.have("video/VP8")


def test_rendition_without_size_is_infinitely_far() -> None:
    first, other = Made("video/VP8", None), Made("video/VP8", None)
    first.is_wanted = True
    assert within_limit([other], first, [first, other], [first, other], 1, 1) == (first,)


def test_sources_that_share_a_limit_have_their_first_renditions_and_together_no_more() -> None:
    limit = EncoderLimit(5)
    one, two = Source(limit), Source(limit)
    for every in (3, 2, 1):
        for index in (2, 1, 0):
            one.have("video/H264", every)[index].is_wanted = True
    assert one.running == 2, "one besides the first, for three places are the others' first renditions"
    for source in (two, one):
        for codec in CODECS:
            first = source.have(codec)[0]
            assert first is source.ladder(codec)[0]
            first.is_wanted = True
    assert one.running + two.running == 5
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
