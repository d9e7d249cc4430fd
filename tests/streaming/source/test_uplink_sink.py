from openrois_streaming.source.uplink_sink import UplinkSelector

from tests.support.streaming import FedSource
from tests.support.viewing import FakeInlet


def ways() -> tuple[FakeInlet, UplinkSelector, FedSource[int], FedSource[int]]:
    inlet = FakeInlet()
    return inlet, UplinkSelector("s", inlet), FedSource(), FedSource()


def test_the_first_way_is_plugged_and_another_when_it_plays() -> None:
    inlet, selector, old, new = ways()
    selector.add(old)
    selector.add(new)
    assert inlet.sources == {"s": old}
    selector.set_playing(new, plays=True)
    selector.set_playing(new, plays=True)
    assert inlet.sources == {"s": new}
    selector.remove(old)
    selector.remove(new)
    assert inlet.calls == [("plug", "s"), ("plug", "s"), ("unplug", "s")]


def test_when_the_way_that_plays_is_gone_the_other_takes_its_place() -> None:
    inlet, selector, old, new = ways()
    selector.add(old)
    selector.add(new)
    selector.set_playing(new, plays=True)
    selector.remove(new)
    assert inlet.sources == {"s": old}
    selector.remove(new)
    selector.remove(old)
    assert inlet.sources == {}


def test_of_two_ways_that_play_the_newer_one_is_plugged_once_and_the_older_when_that_is_silent() -> None:
    inlet, selector, old, new = ways()
    selector.add(old)
    selector.set_playing(old, plays=True)
    selector.add(new)
    for _ in range(3):
        selector.set_playing(new, plays=True)
        selector.set_playing(old, plays=True)
    assert inlet.sources == {"s": new}
    assert inlet.calls == [("plug", "s"), ("plug", "s")]
    selector.set_playing(new, plays=False)
    assert inlet.sources == {"s": old}
    selector.set_playing(old, plays=False)
    assert inlet.sources == {"s": old}, "nothing better is known"
