"""A sink that measures real media of this machine."""

import pytest
from openrois_signaling.messages import Offer
from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink

from tests.support.loopback import Engine, engine

pytestmark = pytest.mark.extra(name="streaming")


def play(one: Engine, sink: MeasuringSink) -> None:
    async def respond(offer: Offer) -> None:
        await one.session.apply_answer(await sink.respond(offer))

    one.application = respond


@pytest.mark.media
async def test_pictures_and_sound_are_measured() -> None:
    async with engine() as one, MeasuringSink() as sink:
        play(one, sink)
        one.connect("s1", "video")
        await sink.sees()
        one.connect("s2", "audio")
        await sink.hears(10)
        sink.restart()
        await sink.until(lambda: sink.lip_sync() and sink.pictures().pictures)
        seen, heard = sink.pictures(), sink.sound()
        assert seen.size == (320, 180)
        assert (seen.unreadable, seen.repeated) == (0, 0)
        assert seen.delay is not None
        assert seen.delay.count == seen.pictures
        assert heard.clicks >= 1
        assert heard.heard > 0
        assert sink.told_lip_sync() is not None
        assert sink.received("0").packets >= seen.pictures
        assert sink.received("0").packets_lost == 0
        assert sink.states[-1] == "connected"
        assert (await sink.picture()).stamp is not None
        assert one.failures == []


@pytest.mark.media
async def test_a_bad_network_shows() -> None:
    async with ImpairedPath(Impairments(delay=0.1)) as path, engine() as one, MeasuringSink(path=path) as sink:
        play(one, sink)
        one.connect("s1", "video")
        await sink.sees(10)
        delay = sink.pictures("0").delay
        assert delay is not None
        assert delay.p50 >= 0.1
        assert sink.sizes()[0][1:] == (320, 180)


async def test_a_section_that_is_not_there() -> None:
    async with MeasuringSink() as sink:
        with pytest.raises(LookupError, match="0 such sections"):
            sink.pictures()
        with pytest.raises(LookupError):
            sink.sound("1")
        assert sink.lip_sync() is None
        with pytest.raises(TimeoutError):
            await sink.sees(within=0)
