from openrois_avatar.link.messages import Command, Demand, LinkError
from openrois_avatar.link.picture_demand import PictureDemand
from openrois_avatar.link.picture_source import EngineVideo

from tests.support.avatar_link import picture
from tests.support.streaming import VirtualClock


def at(seconds: float) -> int:
    return round(seconds * 1e9)


def test_an_engine_is_told_how_many_want_pictures() -> None:
    demand, told = PictureDemand(VirtualClock()), list[Command]()
    with demand.wanted():
        demand.engine_arrived(told.append)
        with demand.wanted():
            assert demand.consumers == 2
    demand.engine_gone()
    with demand.wanted():
        assert not demand.sleeping
    assert told == [Demand(1), Demand(2), Demand(1), Demand(0)]


def test_an_engine_that_is_gone_is_not_told() -> None:
    demand = PictureDemand(VirtualClock())

    def gone(_command: Command) -> None:
        raise LinkError("the engine is gone")

    demand.engine_arrived(gone)
    with demand.wanted():
        assert not demand.sleeping
    assert demand.sleeping


async def test_no_picture_is_given_that_was_drawn_before_it_was_wanted() -> None:
    clock = VirtualClock(now=1000)
    demand = PictureDemand(clock)
    video = EngineVideo(clock, demand)
    demand.engine_arrived(lambda _command: None)
    async with video.open():
        pass
    await clock.advance(0.5)
    async with video.open() as pictures:
        video.put(picture(0, at(1000.49)))
        await clock.advance(0.1)
        video.put(picture(1, at(1000.55)))
        assert (await anext(pictures)).sequence == 1


async def test_an_engine_that_draws_all_the_time_is_believed_its_first_picture() -> None:
    clock = VirtualClock(now=1000)
    video = EngineVideo(clock, PictureDemand(clock))
    async with video.open() as pictures:
        video.put(picture(0, at(999.98)))
        assert (await anext(pictures)).sequence == 0
