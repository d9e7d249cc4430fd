from itertools import islice

from openrois_avatar.link.client import LinkClient
from openrois_avatar.link.messages import Bye, LinkError
from openrois_avatar.link.reconnecting import LONGEST_DELAY, connections

from tests.support.avatar_link import HELLO, FakeAdapter, wire


def test_attempts_slow_down_and_start_over_after_welcome() -> None:
    with FakeAdapter() as first, FakeAdapter() as second:
        attempts = iter(["none", "none", first.address, *["none"] * 5, second.address])
        waited, said = list[float](), list[str]()

        def connect() -> LinkClient:
            address = next(attempts)
            if address == "none":
                raise LinkError("no adapter is there")
            return LinkClient.connect(address, HELLO)

        for link in islice(connections(connect, said.append, waited.append), 2):
            with link:
                assert link.connected
    assert waited == [0.5, 1.0, 0.5, 1.0, 2.0, 4.0, LONGEST_DELAY, LONGEST_DELAY]
    assert said == ["no adapter is there"] * 7


def test_a_refusal_is_told_and_not_the_end() -> None:
    with FakeAdapter(wire(Bye("another engine is connected"))) as busy, FakeAdapter() as free:
        addresses, said = iter([busy.address, free.address]), list[str]()
        found = connections(lambda: LinkClient.connect(next(addresses), HELLO), said.append, lambda _seconds: None)
        with next(found) as link:
            assert link.connected
    assert said == ["refused: another engine is connected"]
