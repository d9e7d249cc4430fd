"""A viewer behind a path that loses packets: what it misses is sent again."""

import pytest
from openrois_signaling.messages import Offer
from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink

from tests.support.loopback import engine

pytestmark = pytest.mark.media


async def test_lost_packets_are_retransmitted_and_pictures_go_on() -> None:
    down = Impairments(delay=0.01, loss=0.05)
    async with ImpairedPath(down) as path, engine() as one, MeasuringSink(path=path) as sink:

        async def respond(offer: Offer) -> None:
            await one.session.apply_answer(await sink.respond(offer))

        one.application = respond
        one.connect("s1", "video")
        await sink.sees(60)
        stats = await one.session.stats("s1")
        assert stats.packets_retransmitted > 0
        assert stats.retransmissions_refused == 0
        assert (one.session.guarded.peer_limit, one.session.guarded.total_limit) == (0, 0)
        assert sink.received("0").packets_lost <= stats.packets_retransmitted + 5
