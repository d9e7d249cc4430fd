"""The Event interface: subscriptions, notifications, details."""

from typing import Any, Final

from openrois_conformance.application import EVENT, Application
from openrois_conformance.checks.system import REFUSED_CONDITIONS
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.probe_engine import EXPIRE
from openrois_conformance.probe_profiles import PARAMETERS, sample
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

SUBSCRIBE: Final = "rois.event.subscribe"
UNSUBSCRIBE: Final = "rois.event.unsubscribe"
DETAIL: Final = "rois.event.get_event_detail"
TYPE: Final = "happened_to_eye"


async def _subscribed(app: Application, event_type: str = TYPE, condition: str = "") -> str:
    subscribe_id = (await app.granted(SUBSCRIBE, event_type=event_type, condition=condition))["subscribe_id"]
    if not subscribe_id:
        raise Deviation("a subscribe_id", "an empty one")
    return str(subscribe_id)


@CHECKS("subscribe", Needs.ADAPTER)
async def _subscribe(stage: Stage) -> None:
    """A subscriber is notified: event_id, event_type, its own subscribe_id, expire, and the results as they were."""
    app = await stage.application()
    subscribe_id = await _subscribed(app)
    owner = stage.ref("eye").partition("/")[0]
    expect(f"the engine id that leads the subscribe_id {subscribe_id}", subscribe_id.partition("/")[0], owner)
    event_id = await stage.probe.happen(stage.ref("eye"), TYPE)
    notice = await app.next(EVENT)
    expect("the subscribe_id", notice["subscribe_id"], subscribe_id)
    expect("the event_type", notice["event_type"], TYPE)
    expect("the event_id, unchanged from the adapter", notice["event_id"], event_id)
    expect("the DateTime until which details are kept", notice["expire"], EXPIRE)
    wanted = [{"name": name, "data_type_ref": code, "value": sample(code)} for name, code, _ in PARAMETERS]
    if notice["results"]:
        expect("the results", notice["results"], wanted)
    else:
        stage.remark("notify_event carries no results; get_event_detail has them")


@CHECKS("subscribe-order", Needs.ADAPTER)
async def _subscribe_order(stage: Stage) -> None:
    """The reply of subscribe comes before its events, and events come in the order in which they happened."""
    app = await stage.application()
    eye = stage.ref("eye")
    request_id = await app.begin(SUBSCRIBE, event_type=TYPE)
    await stage.probe.until(lambda: bool(stage.probe.params_of(SUBSCRIBE)), "subscribe at its adapter")
    happened = [await stage.probe.happen(eye, TYPE) for _ in range(20)]
    first = await app.hear()
    if first.get("id") != request_id:
        raise Deviation("the reply of subscribe before its events", shown(first))
    heard = [(await app.next(EVENT))["event_id"] for _ in happened]
    expect("the events in their order", heard, happened)


@CHECKS("subscribe-selection", Needs.ADAPTER)
async def _subscribe_selection(stage: Stage) -> None:
    """`subscribe` needs a condition that exactly one component with that event satisfies."""
    app = await stage.application()
    engine_id = stage.probe.engine.engine_id
    for event_type, condition, code in (
        ("happened", f"component_ref = '{stage.ref('arm')}'", "OK"),
        ("happened", f"component_ref LIKE '{engine_id}/%'", "BAD_PARAMETER"),
        ("happened", f"component_ref = '{engine_id}/absent'", "UNSUPPORTED"),
        ("shut", f"component_ref = '{stage.ref('arm')}'", "UNSUPPORTED"),
    ):
        came = await app.code(SUBSCRIBE, event_type=event_type, condition=condition)
        expect(f"the return_code of subscribe {event_type} where {condition}", came, code)
    for condition in REFUSED_CONDITIONS:
        await app.refused(SUBSCRIBE, "BAD_PARAMETER", event_type=TYPE, condition=condition)


@CHECKS("subscribe-unknown")
async def _subscribe_unknown(stage: Stage) -> None:
    """`subscribe` to an event that no component has is answered UNSUPPORTED."""
    app = await stage.application()
    await app.refused(SUBSCRIBE, "UNSUPPORTED", event_type="conformance unknown")


@CHECKS("subscribe-again", Needs.ADAPTER)
async def _subscribe_again(stage: Stage) -> None:
    """A repeated subscribe is OK; a subscription of its own is notified of the same event_id."""
    app = await stage.application()
    ids = {await _subscribed(app) for _ in range(3)}
    event_id = await stage.probe.happen(stage.ref("eye"), TYPE)
    notices = [await app.next(EVENT) for _ in ids]
    expect("the subscriptions that are told", {each["subscribe_id"] for each in notices}, ids)
    expect("the event they are told of", {each["event_id"] for each in notices}, {event_id})
    await stage.settle(app)
    if len(ids) < 3:
        stage.remark("a repeated subscribe makes no further subscription, as the standard's text says")


@CHECKS("subscribe-only-subscribers", Needs.ADAPTER)
async def _subscribe_only_subscribers(stage: Stage) -> None:
    """No application is notified of events that it has not subscribed to."""
    app, other = await stage.application(), await stage.application()
    await _subscribed(app)
    await _subscribed(other, "happened", f"component_ref = '{stage.ref('eye')}'")
    await stage.probe.happen(stage.ref("eye"), TYPE)
    await app.next(EVENT)
    await stage.settle(other)
    await stage.settle(app)


@CHECKS("unsubscribe", Needs.ADAPTER)
async def _unsubscribe(stage: Stage) -> None:
    """After unsubscribe no event is notified any more; the adapter's subscription ends with the last one."""
    app = await stage.application()
    eye = stage.ref("eye")
    subscribe_id = await _subscribed(app)
    await stage.probe.happen(eye, TYPE)
    await app.next(EVENT)
    await app.granted(UNSUBSCRIBE, subscribe_id=subscribe_id)
    await stage.probe.happen(eye, TYPE)
    await stage.settle(app)
    await stage.probe.until(lambda: not stage.probe.engine.subscriptions, "unsubscribe at its adapter")


@CHECKS("unsubscribe-unknown", Needs.ADAPTER)
async def _unsubscribe_unknown(stage: Stage) -> None:
    """`unsubscribe` of an unknown id, of one that is gone, and of another application's is OK and has no effect."""
    app, other = await stage.application(), await stage.application()
    mine, gone = await _subscribed(app), await _subscribed(app)
    for subscribe_id in (gone, gone, "unknown", ""):
        await app.granted(UNSUBSCRIBE, subscribe_id=subscribe_id)
    if mine == gone:
        mine = await _subscribed(app)
    await other.granted(UNSUBSCRIBE, subscribe_id=mine)
    await stage.probe.happen(stage.ref("eye"), TYPE)
    expect("the subscription that is told", (await app.next(EVENT))["subscribe_id"], mine)


@CHECKS("event-detail", Needs.ADAPTER)
async def _event_detail(stage: Stage) -> None:
    """`get_event_detail` of an event_id gives the event's results, until it expires, as often as it is asked."""
    app = await stage.application()
    await _subscribed(app)
    await stage.probe.happen(stage.ref("eye"), TYPE)
    notice = await app.next(EVENT)
    wanted = [{"name": name, "data_type_ref": code, "value": sample(code)} for name, code, _ in PARAMETERS]
    for _ in range(2):
        detail = await app.granted(DETAIL, event_id=notice["event_id"])
        expect("the details", detail["results"], wanted)
    await app.refused(DETAIL, "BAD_PARAMETER", event_id=notice["event_id"], condition="component_ref = 'x'")


@CHECKS("event-detail-unknown")
async def _event_detail_unknown(stage: Stage) -> None:
    """`get_event_detail` of an id that was never notified is answered BAD_PARAMETER."""
    app = await stage.application()
    for event_id in ("unknown", "", "conformance-nowhere/evt-1"):
        await app.refused(DETAIL, "BAD_PARAMETER", event_id=event_id)


@CHECKS("event-detail-of-others", Needs.ADAPTER)
async def _event_detail_of_others(stage: Stage) -> None:
    """The details of an event are its subscribers': to another application its id is unknown."""
    app, other = await stage.application(), await stage.application()
    await _subscribed(app)
    await stage.probe.happen(stage.ref("eye"), TYPE)
    notice = await app.next(EVENT)
    if await other.code(DETAIL, event_id=notice["event_id"]) == "OK":
        stage.remark("any application that guesses an event_id reads its details, as at the reference engine")


@CHECKS("event-after-connection", Needs.ADAPTER)
async def _event_after_connection(stage: Stage) -> None:
    """The subscriptions of an application whose connection ended are ended at the adapter."""
    leaving = await stage.application()
    await _subscribed(leaving)
    await leaving.socket.close()
    await stage.probe.until(lambda: not stage.probe.engine.subscriptions, "unsubscribe at its adapter")


@CHECKS("event-foreign-subscription", Needs.ADAPTER)
async def _event_foreign_subscription(stage: Stage) -> None:
    """An event that an adapter notifies for a subscription that it does not have reaches no application."""
    app = await stage.application()
    await _subscribed(app)
    engine = stage.probe.engine
    event_id, ((method, good),) = engine.event(stage.ref("eye"), TYPE)
    await stage.probe.send_notification(method, **{**good, "subscribe_id": engine.mint("unknown")})
    await stage.settle(app)
    await stage.probe.send_notification(method, **good)
    expect("the event", (await app.next(EVENT))["event_id"], event_id)


@CHECKS("event-misfit", Needs.ADAPTER)
async def _event_misfit(stage: Stage) -> None:
    """An event whose type is not the subscription's, or whose id is led by another engine, reaches no application."""
    app = await stage.application()
    await _subscribed(app)
    _, ((method, good),) = stage.probe.engine.event(stage.ref("eye"), TYPE)
    strange: tuple[dict[str, Any], ...] = ({"event_type": "happened"}, {"event_id": "conformance-nowhere/evt-1"})
    for wrong in strange:
        await stage.probe.send_notification(method, **{**good, **wrong})
    condition = f"component_ref = '{stage.ref('eye')}'"
    await app.granted("rois.query.query", query_type="component_status", condition=condition)
    if await app.settled():
        app.unread.clear()
        stage.remark("events with a wrong type or a foreign id are passed on, as by the reference engine")
