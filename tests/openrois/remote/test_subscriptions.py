"""Many sinks over one subscription on the other side, whatever happens meanwhile."""

import asyncio
from collections.abc import Callable

import pytest

from openrois.contract import Event, SubscriptionLost
from openrois.errors import ComponentFailed, EngineUnreachable, TimedOut
from openrois.remote.subscriptions import Key, SharedSubscriptions

RANG: Key = ("robot/bell", "rang")
SHUT: Key = ("robot/door", "shut")


def event(event_id: str) -> Event:
    return Event(event_id, "rang", "robot/bell", "", ())


class OtherSide:
    """Mints ids 1, 2, 3 ... and notes which subscriptions are alive; answers when it is let."""

    def __init__(self) -> None:
        self.alive: set[str] = set()
        self.asked = 0
        self.may_answer = asyncio.Event()
        self.may_answer.set()
        self.refuses = False
        self.shared = SharedSubscriptions(self.subscribe, self.unsubscribe, self.alive.discard)

    async def subscribe(self, _key: Key, register: Callable[[str], None]) -> None:
        self.asked += 1
        await self.may_answer.wait()
        if self.refuses:
            raise TimedOut("no")
        remote_id = str(self.asked)
        self.alive.add(remote_id)
        register(remote_id)

    async def unsubscribe(self, remote_id: str) -> None:
        await self.may_answer.wait()
        self.alive.discard(remote_id)

    def emit(self, remote_id: str, event_id: str) -> None:
        if (key := self.shared.key_of(remote_id)) is not None:
            self.shared.emit(key, event(event_id))


class Heard(list[str]):
    def __call__(self, item: Event | SubscriptionLost) -> None:
        self.append(item.event_id if isinstance(item, Event) else "lost")


@pytest.fixture
async def other() -> OtherSide:
    return OtherSide()


async def settle() -> None:
    for _ in range(10):
        await asyncio.sleep(0)


async def test_many_sinks_share_one_subscription(other: OtherSide) -> None:
    first, second = Heard(), Heard()
    ids = await asyncio.gather(other.shared.add(RANG, first), other.shared.add(RANG, second))
    other.emit("1", "a")
    await other.shared.remove(ids[0])
    other.emit("1", "b")
    assert (first, second, other.asked, other.alive) == (["a"], ["a", "b"], 1, {"1"})
    await other.shared.remove(ids[1])
    await other.shared.remove(ids[1])
    other.emit("1", "c")
    assert (second, other.alive) == (["a", "b"], set())


async def test_each_event_has_its_own(other: OtherSide) -> None:
    rang, shut = Heard(), Heard()
    await other.shared.add(RANG, rang)
    await other.shared.add(SHUT, shut)
    other.emit("2", "a")
    assert (rang, shut) == ([], ["a"])
    assert other.shared.key_of("3") is None


async def test_an_event_that_comes_before_add_returns_is_heard(other: OtherSide) -> None:
    heard = Heard()
    other.may_answer.clear()
    adding = asyncio.ensure_future(other.shared.add(RANG, heard))
    await settle()
    other.may_answer.set()
    asyncio.get_running_loop().call_soon(other.emit, "1", "early")
    await adding
    await settle()
    assert heard == ["early"]


async def test_each_caller_gets_its_own_refusal(other: OtherSide) -> None:
    other.refuses = True
    outcomes = await asyncio.gather(*(other.shared.add(RANG, Heard()) for _ in range(2)), return_exceptions=True)
    assert [type(outcome) for outcome in outcomes] == [TimedOut, TimedOut]
    other.refuses = False
    heard = Heard()
    await other.shared.add(RANG, heard)
    other.emit("3", "a")
    assert (heard, other.alive) == (["a"], {"3"})


async def test_a_cancelled_subscriber_leaves_the_rest(other: OtherSide) -> None:
    other.may_answer.clear()
    heard = Heard()
    first = asyncio.ensure_future(other.shared.add(RANG, Heard()))
    second = asyncio.ensure_future(other.shared.add(RANG, heard))
    await settle()
    first.cancel()
    other.may_answer.set()
    await second
    other.emit("2", "a")
    assert (heard, other.alive) == (["a"], {"2"})


async def test_a_subscriber_cancelled_when_the_answer_came_leaves_nothing(other: OtherSide) -> None:
    inner = other.shared._subscribe

    async def subscribe(key: Key, register: Callable[[str], None]) -> None:
        await inner(key, register)
        raise asyncio.CancelledError

    other.shared._subscribe = subscribe
    with pytest.raises(asyncio.CancelledError):
        await other.shared.add(RANG, Heard())
    assert other.alive == set()
    assert other.shared.key_of("1") is None


async def test_a_subscriber_that_comes_while_the_last_leaves_gets_events(other: OtherSide) -> None:
    subscribe_id = await other.shared.add(RANG, Heard())
    other.may_answer.clear()
    leaving = asyncio.ensure_future(other.shared.remove(subscribe_id))
    heard = Heard()
    coming = asyncio.ensure_future(other.shared.add(RANG, heard))
    await settle()
    other.may_answer.set()
    await asyncio.gather(leaving, coming)
    other.emit("1", "old")
    other.emit("2", "new")
    assert (heard, other.alive) == (["new"], {"2"})


async def test_the_end_is_told_to_every_sink_once(other: OtherSide) -> None:
    rang, shut = Heard(), Heard()
    subscribe_id = await other.shared.add(RANG, rang)
    await other.shared.add(SHUT, shut)
    other.shared.lost(SubscriptionLost("gone"))
    other.shared.lost(SubscriptionLost("gone"))
    await other.shared.remove(subscribe_id)
    other.emit("1", "late")
    assert (rang, shut) == (["lost"], ["lost"])


async def test_an_id_minted_twice_is_refused(other: OtherSide) -> None:
    await other.shared.add(RANG, Heard())
    other.asked = 0
    with pytest.raises(ComponentFailed):
        await other.shared.add(SHUT, Heard())
    assert other.shared.key_of("1") == RANG


class TestTreeChanged:
    async def test_the_next_to_come_subscribes_anew_for_all(self, other: OtherSide) -> None:
        first, second = Heard(), Heard()
        await other.shared.add(RANG, first)
        other.shared.tree_changed()
        await other.shared.add(RANG, second)
        other.emit("1", "old")
        other.emit("2", "new")
        assert (first, second, other.alive) == (["new"], ["new"], {"2"})
        await other.shared.add(RANG, Heard())
        assert other.asked == 2

    async def test_a_refusal_then_leaves_the_old_one(self, other: OtherSide) -> None:
        heard = Heard()
        await other.shared.add(RANG, heard)
        other.shared.tree_changed()
        other.refuses = True
        with pytest.raises(TimedOut):
            await other.shared.add(RANG, Heard())
        other.emit("1", "old")
        assert heard == ["old"]

    async def test_sinks_of_components_that_are_gone_are_told(self, other: OtherSide) -> None:
        rang, shut = Heard(), Heard()
        subscribe_id = await other.shared.add(RANG, rang)
        await other.shared.add(SHUT, shut)
        other.shared.keep_only({SHUT[0]}, SubscriptionLost("gone"))
        other.emit("1", "late")
        other.emit("2", "still")
        await other.shared.remove(subscribe_id)
        assert (rang, shut, other.alive) == (["lost"], ["still"], {"2"})

    async def test_and_so_is_a_subscriber_that_still_waits(self, other: OtherSide) -> None:
        other.may_answer.clear()
        heard = Heard()
        adding = asyncio.ensure_future(other.shared.add(RANG, heard))
        await settle()
        other.shared.keep_only(set(), SubscriptionLost("gone"))
        other.may_answer.set()
        with pytest.raises(EngineUnreachable):
            await adding
        assert (heard, other.alive) == (["lost"], set())
