"""Subscriptions and event details of one application, where things happen at the wrong moment."""

import asyncio
import json
import weakref
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from openrois.contract import Event, Sink, SubscriptionLost
from openrois.engine.engine import Engine
from openrois.errors import BadParameter, EngineUnreachable, OutOfResources, TimedOut
from openrois.session.events import DETAIL_LIFETIME, MAX_DETAILS, MAX_HELD, MAX_SUBSCRIPTIONS, EventLog
from openrois.types.codes import StreamStatus
from openrois.types.messages import Result
from openrois.types.streams import StreamStatusNotification

BELL = "robot/bell"


def event(event_id: str, expire: str = "later") -> Event:
    return Event(event_id, "rang", BELL, expire, (Result(name="tune", data_type_ref="string", value=event_id),))


class Bus(Engine):
    """An engine whose subscriptions are done by hand."""

    def __init__(self) -> None:
        super().__init__("gateway")
        self.sinks: dict[str, Sink] = {}
        self.ended: list[str] = []
        self.may_answer = asyncio.Event()
        self.may_answer.set()
        self.failure: Exception | None = None

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        subscribe_id = f"bus-{len(self.sinks)}"
        self.sinks[subscribe_id] = sink
        await self.may_answer.wait()
        if self.failure is not None:
            raise self.failure
        return subscribe_id

    async def unsubscribe(self, subscribe_id: str) -> None:
        self.ended.append(subscribe_id)
        if self.failure is not None:
            raise self.failure

    def emit(self, item: Event | SubscriptionLost) -> None:
        for sink in self.sinks.values():
            sink(item)


@dataclass
class Timer:
    at: float
    act: Callable[[], None]
    is_cancelled: bool = False

    def cancel(self) -> None:
        self.is_cancelled = True


class Setting:
    def __init__(self) -> None:
        self.now = 100.0
        self.wall = 0.0
        self.bus = Bus()
        self.told: list[tuple[str, str]] = []
        self.expire = ""
        self.timers: list[Timer] = []
        self.log = EventLog(self.bus, self._notify, lambda: self.now, lambda: self.wall, self._later)

    def _later(self, seconds: float, act: Callable[[], None]) -> "Timer":
        self.timers.append(Timer(self.now + seconds, act))
        return self.timers[-1]

    def pass_time(self, seconds: float) -> None:
        """Let time pass, and do once what is due by then."""
        self.now += seconds
        self.wall += seconds
        due = [timer for timer in self.timers if timer.at <= self.now]
        self.timers = [timer for timer in self.timers if timer not in due]
        for timer in due:
            timer.act()

    def _notify(self, method: str, text: str, *, droppable: bool) -> None:
        params = json.loads(text)
        assert (method, droppable) == ("rois.event.notify_event", True)
        self.told.append((params["subscribe_id"], params["event_id"]))
        self.expire = params["expire"]

    async def subscribe(self, event_type: str = "rang", *, of_streams: bool = False) -> tuple[str, Callable[[], None]]:
        reply = await self.log.subscribe(BELL, event_type, of_streams=of_streams)
        assert reply.then is not None
        return reply.result.subscribe_id, reply.then


@pytest.fixture
async def setting() -> Setting:
    return Setting()


async def test_events_wait_until_the_reply_has_left(setting: Setting) -> None:
    subscribe_id, reply_left = await setting.subscribe()
    setting.bus.emit(event("a"))
    assert setting.told == []
    reply_left()
    setting.bus.emit(event("b"))
    assert setting.told == [(subscribe_id, "a"), (subscribe_id, "b")]


async def test_of_too_many_that_wait_the_oldest_go(setting: Setting) -> None:
    _, reply_left = await setting.subscribe()
    for number in range(MAX_HELD + 2):
        setting.bus.emit(event(str(number)))
    reply_left()
    assert [event_id for _, event_id in setting.told] == [str(number) for number in range(2, MAX_HELD + 2)]


async def test_details_are_kept_for_a_while(setting: Setting) -> None:
    _, reply_left = await setting.subscribe()
    reply_left()
    setting.bus.emit(event("a"))
    setting.now += DETAIL_LIFETIME - 0.001
    assert setting.log.details("a") == event("a").results
    setting.now += 0.001
    for event_id in ("a", "never told"):
        with pytest.raises(BadParameter):
            setting.log.details(event_id)


@pytest.mark.parametrize("expire", ["1970-01-01T00:00:30+00:00", "1970-01-01T01:00:30+01:00", "1970-01-01T00:00:30"])
async def test_details_expire_when_the_event_says(setting: Setting, expire: str) -> None:
    _, reply_left = await setting.subscribe()
    reply_left()
    setting.wall = -60
    setting.bus.emit(event("a", expire))
    # The wall clock is set.
    setting.wall = 7200
    setting.now += 89
    assert setting.log.details("a") == event("a").results
    setting.now += 1
    with pytest.raises(BadParameter):
        setting.log.details("a")


async def test_what_has_expired_takes_no_memory(setting: Setting) -> None:
    _, reply_left = await setting.subscribe()
    reply_left()
    for each in (event("short"), event("long", "1970-01-01T00:01:30+00:00")):
        setting.bus.emit(each)
    assert (len(setting.log._details), len(setting.timers)) == (2, 1)
    setting.pass_time(DETAIL_LIFETIME)
    assert len(setting.log._details) == 1
    assert setting.log.details("long") == event("long").results
    setting.pass_time(DETAIL_LIFETIME)
    assert len(setting.log._details) == 0
    # With nothing left nothing wakes the gateway until another event comes.
    assert setting.timers == []
    setting.bus.emit(event("another"))
    assert len(setting.timers) == 1


async def test_of_an_event_that_was_notified_its_text_alone_is_kept(setting: Setting) -> None:
    _, reply_left = await setting.subscribe()
    reply_left()
    notified = event("a")
    kept = weakref.ref(notified), weakref.ref(notified.results[0])
    setting.bus.emit(notified)
    del notified
    assert [each() for each in kept] == [None, None]
    assert setting.log.details("a") == event("a").results


async def test_an_application_that_has_gone_leaves_no_timer(setting: Setting) -> None:
    setting.log.close()
    _, reply_left = await setting.subscribe()
    reply_left()
    setting.bus.emit(event("a"))
    setting.log.close()
    assert [timer.is_cancelled for timer in setting.timers] == [True]


async def test_details_are_bounded(setting: Setting) -> None:
    _, reply_left = await setting.subscribe()
    reply_left()
    for number in range(MAX_DETAILS + 1):
        setting.bus.emit(event(str(number)))
    with pytest.raises(BadParameter):
        setting.log.details("0")
    assert setting.log.details("1")


async def test_subscriptions_are_bounded(setting: Setting) -> None:
    ids = [(await setting.subscribe())[0] for _ in range(MAX_SUBSCRIPTIONS)]
    with pytest.raises(OutOfResources):
        await setting.subscribe()
    await setting.log.unsubscribe(ids[0])
    await setting.subscribe()


async def test_a_refused_subscription_is_none(setting: Setting) -> None:
    setting.bus.failure = TimedOut("no")
    with pytest.raises(TimedOut):
        await setting.subscribe()
    setting.bus.emit(event("a"))
    assert setting.told == []


@pytest.mark.parametrize("how", ["lost", "lost and refused", "left"])
async def test_a_subscription_that_ends_before_it_began(setting: Setting, how: str) -> None:
    setting.bus.may_answer.clear()
    subscribing = asyncio.ensure_future(setting.subscribe())
    await asyncio.sleep(0)
    if how == "left":
        await setting.log.clear()
    else:
        setting.bus.emit(SubscriptionLost("gone"))
    setting.bus.failure = EngineUnreachable("gone") if how == "lost and refused" else None
    setting.bus.may_answer.set()
    with pytest.raises(EngineUnreachable):
        await subscribing
    assert setting.bus.ended == ([] if how == "lost and refused" else ["bus-0"])


async def test_a_lost_subscription_is_forgotten(setting: Setting) -> None:
    subscribe_id, reply_left = await setting.subscribe()
    reply_left()
    setting.bus.emit(SubscriptionLost("gone"))
    await setting.log.unsubscribe(subscribe_id)
    assert setting.bus.ended == []


async def test_one_that_cannot_be_ended_does_not_keep_the_others(setting: Setting) -> None:
    for _ in range(3):
        await setting.subscribe()
    setting.bus.failure = TimedOut("no")
    await setting.log.clear()
    await setting.log.clear()
    assert sorted(setting.bus.ended) == ["bus-0", "bus-1", "bus-2"]


class TestOwnStreams:
    NOTICE = StreamStatusNotification(
        stream_id="robot/1", component_ref=BELL, status=StreamStatus.STREAMING_RUNNING, timestamp="now"
    )

    async def test_their_status_needs_no_subscription_at_the_engine(self, setting: Setting) -> None:
        subscribe_id, reply_left = await setting.subscribe("notify_stream_status", of_streams=True)
        _, other_left = await setting.subscribe("rang", of_streams=True)
        other_left()
        setting.log.stream_status(self.NOTICE)
        setting.log.stream_status(self.NOTICE.model_copy(update={"component_ref": "robot/other"}))
        assert setting.told == []
        reply_left()
        ((told_id, event_id),) = setting.told
        assert (told_id, setting.expire) == (subscribe_id, "1970-01-01T00:01:00.000000+00:00")
        assert [(result.name, result.value) for result in setting.log.details(event_id)] == [
            ("timestamp", "now"),
            ("status", "STREAMING_RUNNING"),
            ("stream_id", "robot/1"),
        ]
        assert list(setting.bus.sinks) == ["bus-0"]
        await setting.log.unsubscribe(subscribe_id)
        setting.log.stream_status(self.NOTICE)
        assert len(setting.told) == 1

    async def test_they_end_with_their_component(self, setting: Setting) -> None:
        _, reply_left = await setting.subscribe("notify_stream_status", of_streams=True)
        reply_left()
        _, other_left = await setting.subscribe()
        other_left()
        setting.log.keep_only({BELL})
        setting.log.stream_status(self.NOTICE)
        assert len(setting.told) == 1
        setting.log.keep_only(set())
        setting.log.stream_status(self.NOTICE)
        setting.bus.emit(event("a"))
        assert [event_id for _, event_id in setting.told[1:]] == ["a"]
