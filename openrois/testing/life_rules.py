"""Rules of a component towards its adapter, in one process: connecting, disconnecting, and announcing its events."""

import asyncio

from openrois.contract import Event
from openrois.errors import ComponentFailed
from openrois.testing.message_rules import begin, can, stop_ends_start
from openrois.testing.samples import argument, result
from openrois.testing.subject import EventCollector, LocalSubject, require
from openrois.types.values import check_value

__all__ = [
    "events_are_heard_until_unsubscribed",
    "it_comes_up_again",
    "it_lets_go",
    "without_connection_it_only_keeps_parameters",
]


async def it_comes_up_again(subject: LocalSubject) -> None:
    """A component that was disconnected can be connected again, and works as before."""
    for _ in range(2):
        await subject.within("disconnect", subject.component.take_down())
        require(await subject.within("connect", subject.component.bring_up()), "connect failed; the log says why")
    await stop_ends_start(subject)


async def it_lets_go(subject: LocalSubject) -> None:
    """When the adapter ends, so does a `start` that runs; the component is UNINITIALIZED then."""
    running = await begin(subject) if can(subject, "start") else None
    await subject.within("disconnect", subject.component.take_down())
    if running is not None:
        done, _ = await asyncio.wait({running}, timeout=subject.patience)
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        require(bool(done), "start goes on after the component was let go")
    require(
        subject.component.status == "UNINITIALIZED", f"after it was let go its status is {subject.component.status}"
    )


async def without_connection_it_only_keeps_parameters(subject: LocalSubject) -> None:
    """UNINITIALIZED it answers its status and its parameters, and everything else fails."""
    await subject.within("disconnect", subject.component.take_down())
    ref, profile = subject.component_ref, subject.profile
    for query in profile.query_profiles:
        if query.name == "component_status":
            require(await subject.status() == "UNINITIALIZED", "component_status does not say UNINITIALIZED")
        else:
            await subject.refused(f"query {query.name}", subject.bus.query(ref, query.name), ComponentFailed)
    for command in profile.command_profiles:
        fitting = tuple(argument(each) for each in command.arguments)
        work = subject.bus.invoke(ref, command.name, fitting)
        await subject.refused(f"command {command.name}", work, ComponentFailed)
    for event in profile.event_profiles:
        listening = subject.bus.subscribe(ref, event.name, EventCollector())
        await subject.refused(f"subscribe to {event.name}", listening, ComponentFailed)
    await subject.prepare()
    values = await subject.parameter_values()
    for name, value in subject.parameters.items():
        require(values.get(name) == value, f"{name} was set to {value!r}, get_parameter tells {values.get(name)!r}")


async def events_are_heard_until_unsubscribed(subject: LocalSubject) -> None:
    """One announcement is one event for every subscriber, with results that fit, and silence afterwards."""
    for event in subject.profile.event_profiles:
        staying, leaving = EventCollector(), EventCollector()
        await subject.bus.subscribe(subject.component_ref, event.name, staying)
        leaving_id = await subject.bus.subscribe(subject.component_ref, event.name, leaving)
        results = tuple(result(profile) for profile in event.results)
        subject.component.emit(event.name, results)
        await subject.bus.unsubscribe(leaving_id)
        subject.component.emit(event.name, results)
        require(len(staying.received) == 2, f"of two {event.name} {len(staying.received)} are heard")
        require(len(leaving.received) == 1, f"{event.name} is heard after unsubscribe")
        first, again = staying.received[0], leaving.received[0]
        require(isinstance(first, Event) and first == again, f"two who listen to {event.name} hear different events")
        if isinstance(first, Event):
            subject.require_fitting(f"event {event.name}", first.results, event.results)
            check_value("DateTime", first.expire)
