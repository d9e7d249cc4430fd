"""Rules of a component towards its clients: queries, commands, events, status, and the life of `start`."""

import asyncio
from typing import Final

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.errors import Aborted, BadParameter, Unsupported
from openrois.testing.samples import argument, misfit
from openrois.testing.subject import Broken, EventCollector, Subject, require
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument, Result
from openrois.types.profiles import ParameterProfile, RoISIdentifier

__all__ = [
    "UNKNOWN",
    "a_new_start_ends_the_former",
    "begin",
    "can",
    "it_pauses_and_goes_on",
    "it_refuses_arguments_that_it_does_not_take",
    "it_refuses_unknown_messages",
    "it_tells_its_status",
    "its_events_can_be_subscribed",
    "its_queries_answer",
    "stop_ends_start",
]

UNKNOWN: Final = "no_such_thing"
GLANCE: Final = 0.01
"""Seconds between two checks of what takes its time."""
ENDING: Final = 1.0
"""Seconds that a command has to clean up when it is cancelled."""

_STRANGE: Final = ParameterProfile(name=UNKNOWN, data_type_ref=RoISIdentifier(code="string"))


async def it_tells_its_status(subject: Subject) -> None:
    """`component_status` answers with a status, and it is one that can be used."""
    if subject.has_status:
        results = await subject.query("component_status")
        require([result.name for result in results] == ["status"], "component_status gives more or less than `status`")
        status = results[0].value
        require(status in ComponentStatus.__members__, f"{status!r} is no status of a component")
        require(status in ("READY", "BUSY"), f"it cannot be tried: its status is {status}")


async def its_queries_answer(subject: Subject) -> None:
    """Every query answers with what its profile promises and nothing else; what the standard requires is there."""
    for profile in subject.profile.query_profiles:
        if profile.name not in subject.refuses and profile.name != _OF_ONE_STREAM:
            results = await subject.query(profile.name)
            subject.require_fitting(f"query {profile.name}", results, profile.results)
            require(bool(results) or not profile.results, f"query {profile.name} gives nothing of what it promises")
            missing = _required(subject, profile.name) - {result.name for result in results}
            require(not missing, f"query {profile.name} lacks what the standard requires: {', '.join(sorted(missing))}")


_OF_ONE_STREAM: Final = "get_stream_status"
"""Query whose condition names a stream of the application that asks (RoIS 2.0, table 8.6); here there is none."""


def _required(subject: Subject, query: str) -> set[str]:
    """Return the results of a query that are mandatory in the component's type."""
    kind = next((kind for kind in BASIC_COMPONENTS if kind.urn == subject.profile.component_type), ROIS_COMMON)
    found = next((each.results.data() for each in kind.all_queries() if each.name == query), {})
    return {name for name, data in found.items() if data.obligation == "M"}


async def it_refuses_unknown_messages(subject: Subject) -> None:
    """A command, query or event that the profile does not name is Unsupported."""
    bus, ref = subject.bus, subject.component_ref
    await subject.refused("an unknown query", bus.query(ref, UNKNOWN), Unsupported)
    await subject.refused("an unknown command", bus.invoke(ref, UNKNOWN), Unsupported)
    await subject.refused("an unknown event", bus.subscribe(ref, UNKNOWN, EventCollector()), Unsupported)


async def it_refuses_arguments_that_it_does_not_take(subject: Subject) -> None:
    """Unknown, misfitting and repeated arguments are BadParameter, and the command does not start."""
    collector = EventCollector()
    ids = [
        await subject.bus.subscribe(subject.component_ref, event.name, collector)
        for event in subject.profile.event_profiles
    ]
    before = await subject.parameter_values()
    for command in subject.profile.command_profiles:
        for wrong, arguments in _wrong(command.arguments):
            doing = f"command {command.name} with {wrong}"
            work = subject.bus.invoke(subject.component_ref, command.name, arguments)
            await subject.refused(doing, work, BadParameter)
            require(not collector.received, f"{doing} was refused, yet it announced {collector.received[:1]}")
            if subject.has_status:
                require(await subject.status() != "BUSY", f"{doing} was refused, yet something runs")
    require(await subject.parameter_values() == before, "a command that was refused has changed parameters")
    for subscribe_id in ids:
        await subject.bus.unsubscribe(subscribe_id)


def _wrong(profiles: tuple[ParameterProfile, ...]) -> list[tuple[str, tuple[Argument, ...]]]:
    """Return arguments that do not fit the profiles, each with its problem."""
    fitting = tuple(argument(profile) for profile in profiles)
    found = [("an unknown argument", (*fitting, argument(_STRANGE)))]
    for profile, fits in zip(profiles, fitting, strict=True):
        found.append((f"{profile.name} twice", (*fitting, fits)))
        bad = misfit(profile.data_type_ref.code)
        if bad is not None:
            others = tuple(other for other in fitting if other is not fits)
            found.append((f"{profile.name} {bad!r}", (*others, argument(profile, bad))))
    return found


async def stop_ends_start(subject: Subject) -> None:
    """While `start` runs the status is BUSY; `stop` ends it with ABORT, and then it is not BUSY any more."""
    if not can(subject, "start"):
        return
    running = await begin(subject)
    try:
        if can(subject, "stop"):
            await subject.invoke("stop")
            await _ended(subject, running, "stop")
    finally:
        await _end(running)
    if subject.has_status:
        require(await subject.status() != "BUSY", "it is still BUSY after start has ended")


async def a_new_start_ends_the_former(subject: Subject) -> None:
    """Of `start` one runs at a time: the next one ends the former with ABORT."""
    if not can(subject, "start"):
        return
    first = await begin(subject)
    second = None
    try:
        if not first.done():
            second = asyncio.ensure_future(subject.bus.invoke(subject.component_ref, "start"))
            await _ended(subject, first, "a new start")
        if can(subject, "stop"):
            await subject.invoke("stop")
    finally:
        await _end(first)
        if second is not None:
            await _end(second)


async def it_pauses_and_goes_on(subject: Subject) -> None:
    """A component that can be suspended can be resumed, while `start` runs."""
    pair = [name for name in ("suspend", "resume") if subject.profile.command(name) is not None]
    require(len(pair) != 1, f"it has {pair}, which is nothing without the other")
    if not pair or not can(subject, "start"):
        return
    running = await begin(subject)
    try:
        for name in pair:
            if not running.done() and name not in subject.refuses:
                await subject.invoke(name)
        if can(subject, "stop"):
            await subject.invoke("stop")
    finally:
        await _end(running)


def can(subject: Subject, command: str) -> bool:
    """Tell whether a command exists and may be tried."""
    return subject.profile.command(command) is not None and command not in subject.refuses


async def begin(subject: Subject) -> "asyncio.Future[tuple[Result, ...]]":
    """Run `start` until it has ended or the component is BUSY."""
    await subject.prepare()
    running = asyncio.ensure_future(subject.bus.invoke(subject.component_ref, "start"))

    async def begun() -> None:
        while not running.done() and not (subject.has_status and await subject.status() == "BUSY"):
            await asyncio.wait({running}, timeout=GLANCE)

    try:
        await subject.within("start runs, and the status does not become BUSY: that", begun())
    except BaseException:
        await _end(running)
        raise
    if running.done() and (error := running.exception()) is not None:
        raise Broken(f"start failed: {error}; is there something to set first? `parameters` says what") from error
    return running


async def _ended(subject: Subject, running: "asyncio.Future[tuple[Result, ...]]", by: str) -> None:
    """Require that `start` ends, with ABORT where it was still running."""
    done, _ = await asyncio.wait({running}, timeout=subject.patience)
    require(bool(done), f"start goes on {subject.patience:g} s after {by}")
    error = running.exception()
    ended_well = error is None or isinstance(error, Aborted)
    require(ended_well, f"start ended by {by} with {type(error).__name__}, not ABORT: {error}")


async def _end(running: "asyncio.Future[tuple[Result, ...]]") -> None:
    running.cancel()
    done, _ = await asyncio.wait({running}, timeout=ENDING)
    require(bool(done), "start goes on when it is cancelled: let CancelledError pass, and clean up in `finally`")
    if not running.cancelled():
        running.exception()


async def its_events_can_be_subscribed(subject: Subject) -> None:
    """Every event of the profile can be subscribed, any number of times, and unsubscribed; once more is ignored."""
    for event in subject.profile.event_profiles:
        ids: list[str] = []
        for _ in range(2):
            doing = f"subscribe to {event.name}"
            subscribed = subject.bus.subscribe(subject.component_ref, event.name, EventCollector())
            ids.append(await subject.within(doing, subscribed))
        require(all(ids) and ids[0] != ids[1], f"two subscriptions to {event.name} have the ids {ids}")
        for subscribe_id in (*ids, *ids):
            await subject.within(f"unsubscribe from {event.name}", subject.bus.unsubscribe(subscribe_id))
