"""Components that break the contract, each in one way: the suite has to find it, by the rule that it is about."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from openrois.adapter import BadParameter, Component, ComponentFailed, command, event, parameter, query
from openrois.component.component import Component as Plain
from openrois.contract import Sink
from openrois.engine.registry import LocalRegistry
from openrois.errors import RoISError, Unsupported
from openrois.testing import ComponentContract, findings, message_rules
from openrois.testing.contract import LOCAL_RULES, RULES
from openrois.types.codes import ComponentFunction, ComponentStatus
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile, RoISIdentifier
from tests.support.basics import Navigation, SystemInformation

pytestmark = pytest.mark.extra(name="base")

PATIENCE = 0.05
"""Seconds until what is not as it should be is given up."""


class Motor(Component, authority="Test"):
    """What keeps the contract: it runs until it is stopped, and can pause."""

    speed: int = parameter(5)
    label: str = parameter("motor")

    @command
    async def start(self) -> None:
        await asyncio.Event().wait()

    @command
    async def stop(self) -> None: ...

    @command
    async def suspend(self) -> None: ...

    @command
    async def resume(self) -> None: ...

    @command
    async def turn(self, degrees: int, note: str = "") -> None:
        self.turned(degrees)

    @query
    async def temperature(self) -> float:
        return 20.0

    @event
    def turned(self, degrees: int) -> None: ...


class Bus(LocalRegistry):
    """Motors behind a registry; a subclass does one thing wrong."""

    def __init__(self, motor: Component | None = None) -> None:
        super().__init__("engine", [motor or Motor()])


async def rules_broken(bus: LocalRegistry) -> set[str]:
    return {finding.rule for finding in await findings(bus, patience=PATIENCE)}


async def test_what_keeps_the_contract_has_no_findings() -> None:
    assert await findings(Bus()) == []


# What a profile says.


def profiled(**changes: Any) -> Motor:
    """Return a motor whose profile says something else than it should."""
    motor = Motor()
    motor.__dict__["profile"] = motor.profile.model_copy(update=changes)
    return motor


def repeated(profile: HRIComponentProfile) -> Motor:
    return profiled(parameter_profiles=(*profile.parameter_profiles, profile.parameter_profiles[0]))


def misdefaulted(profile: HRIComponentProfile) -> Motor:
    speed, label = profile.parameter_profiles
    return profiled(parameter_profiles=(speed.model_copy(update={"default_value": "fast"}), label))


def unspeakable(profile: HRIComponentProfile) -> Motor:
    speed, label = profile.parameter_profiles
    return profiled(parameter_profiles=(speed.model_copy(update={"description": "\x00"}), label))


def late(profile: HRIComponentProfile) -> Motor:
    return profiled(command_profiles=tuple(reversed(profile.command_profiles)))


def standing_in(profile: HRIComponentProfile) -> Component:
    navigation = Navigation()
    changed = navigation.profile.parameter_profiles[0].model_copy(
        update={"data_type_ref": RoISIdentifier(code="string")}
    )
    rest = navigation.profile.parameter_profiles[1:]
    navigation.__dict__["profile"] = navigation.profile.model_copy(update={"parameter_profiles": (changed, *rest)})
    return navigation


def of_no_class(profile: HRIComponentProfile) -> Component:
    navigation = Navigation()
    navigation.__dict__["profile"] = navigation.profile.model_copy(update={"function": ComponentFunction.SENSING})
    return navigation


@pytest.mark.parametrize(
    ("make", "rule"),
    [
        (lambda _profile: profiled(identifier=RoISIdentifier(code="motor")), "it_has_an_identity"),
        (repeated, "its_profile_can_be_read"),
        (misdefaulted, "its_profile_can_be_read"),
        (unspeakable, "its_profile_can_be_read"),
        (late, "its_profile_keeps_to_its_type"),
        (standing_in, "its_profile_keeps_to_its_type"),
        (of_no_class, "its_profile_keeps_to_its_type"),
    ],
)
async def test_a_profile_that_is_not_in_order(make: Callable[[HRIComponentProfile], Component], rule: str) -> None:
    assert rule in await rules_broken(Bus(make(Motor().profile)))


async def test_a_command_that_its_type_requires() -> None:
    class Mistyped(Navigation):
        @command
        async def strat(self) -> None: ...

    mistyped = Mistyped()
    kept = tuple(each for each in mistyped.profile.command_profiles if each.name != "start")
    mistyped.__dict__["profile"] = mistyped.profile.model_copy(update={"command_profiles": kept})
    said = {each.rule: each.sentence for each in await findings(Bus(mistyped), patience=PATIENCE)}
    assert said["it_has_the_commands_of_its_type"] == (
        "urn:x-rois:def:component:OMG::Navigation requires start; its commands are stop, strat"
    )


# What a component answers.


class Forgetful(Motor):
    async def temperature(self) -> float:
        raise OSError("the thermometer is gone")


class Resultless(Bus):
    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        return () if query_type == "temperature" else await super().query(component_ref, query_type)


class Mistyped(Bus):
    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        results = await super().query(component_ref, query_type)
        return tuple(result.model_copy(update={"data_type_ref": "float"}) for result in results)


class Misnamed(Bus):
    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        results = await super().query(component_ref, query_type)
        return tuple(result.model_copy(update={"name": result.name + "_"}) for result in results)


class Curt(Bus):
    """Leaves out what the standard requires."""

    def __init__(self) -> None:
        super().__init__(SystemInformation())

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        return (await super().query(component_ref, query_type))[:1]


class Slow(Bus):
    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        if query_type == "temperature":
            await asyncio.Event().wait()
        return await super().query(component_ref, query_type)


class Accommodating(Bus):
    """Takes whatever it does not know."""

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        try:
            return await super().query(component_ref, query_type)
        except Unsupported:
            return ()


class Vague(Bus):
    """Says that something is wrong, and not what."""

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        try:
            return await super().invoke(component_ref, command_type, arguments)
        except (BadParameter, Unsupported) as error:
            raise ComponentFailed(str(error)) from error


class Lax(Bus):
    """Drops the arguments that it does not know."""

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        known = tuple(argument for argument in arguments if argument.name != "no_such_thing")
        return await super().invoke(component_ref, command_type, known)


class Hasty(Bus):
    """Turns first and reads the arguments afterwards."""

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        if command_type == "turn":
            await super().invoke(component_ref, "turn", (Argument(name="degrees", data_type_ref="int", value="1"),))
        return await super().invoke(component_ref, command_type, arguments)


class Unstoppable(Motor):
    async def start(self) -> None:
        while True:
            try:
                await asyncio.sleep(PATIENCE * 3)
                return
            except asyncio.CancelledError:
                if asyncio.get_running_loop().time() < self.until:
                    continue
                raise

    def __init__(self) -> None:
        self.until = asyncio.get_running_loop().time() + PATIENCE * 3


class Idle(Bus):
    """Runs without saying so."""

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        if query_type == "component_status":
            return (Result(name="status", data_type_ref="Component_Status", value="READY"),)
        return await super().query(component_ref, query_type)


class Diligent(Bus):
    """Is busy for ever."""

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        if query_type == "component_status":
            return (Result(name="status", data_type_ref="Component_Status", value="BUSY"),)
        return await super().query(component_ref, query_type)


class Ill(Motor):
    def condition(self) -> ComponentStatus:
        return ComponentStatus.ERROR


class Shy(Motor):
    async def start(self) -> None:
        raise BadParameter("set something first")


class Crowded(Bus):
    """Lets any number of `start` run."""

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        if command_type == "start" and self._component(component_ref).status == "BUSY":
            return ()
        return await super().invoke(component_ref, command_type, arguments)


class Wilful(Motor):
    async def suspend(self) -> None:
        raise OSError("it does not want to")


class Half(Component, authority="Test"):
    @command
    async def start(self) -> None: ...

    @command
    async def suspend(self) -> None: ...


@pytest.mark.parametrize(
    ("make", "rule"),
    [
        (lambda: Bus(Forgetful()), "its_queries_answer"),
        (Resultless, "its_queries_answer"),
        (Mistyped, "its_queries_answer"),
        (Misnamed, "its_queries_answer"),
        (Curt, "its_queries_answer"),
        (Slow, "its_queries_answer"),
        (Accommodating, "it_refuses_unknown_messages"),
        (Accommodating, "it_refuses_unknown_components"),
        (Vague, "it_refuses_unknown_messages"),
        (Vague, "it_refuses_arguments_that_it_does_not_take"),
        (Lax, "it_refuses_arguments_that_it_does_not_take"),
        (Hasty, "it_refuses_arguments_that_it_does_not_take"),
        (lambda: Bus(Unstoppable()), "stop_ends_start"),
        (Idle, "stop_ends_start"),
        (Diligent, "stop_ends_start"),
        (lambda: Bus(Ill()), "it_tells_its_status"),
        (lambda: Bus(Shy()), "stop_ends_start"),
        (Crowded, "a_new_start_ends_the_former"),
        (lambda: Bus(Wilful()), "it_pauses_and_goes_on"),
        (lambda: Bus(Half()), "it_pauses_and_goes_on"),
    ],
)
async def test_a_component_that_does_not_do_as_it_is_told(make: Callable[[], LocalRegistry], rule: str) -> None:
    assert rule in await rules_broken(make())


# Parameters and events.


class Deaf(Bus):
    """Says OK and stores nothing."""

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        if command_type == "set_parameter":
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(Plain, "accept_parameters", lambda _self, _changes: {})
                return await super().invoke(component_ref, command_type, arguments)
        return await super().invoke(component_ref, command_type, arguments)


class Piecemeal(Bus):
    """Stores one parameter after the other until one does not fit."""

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        if command_type == "set_parameter":
            for argument in arguments:
                await super().invoke(component_ref, command_type, (argument,))
            return ()
        return await super().invoke(component_ref, command_type, arguments)


class Secretive(Bus):
    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        return () if query_type == "get_parameter" else await super().query(component_ref, query_type)


class OneEar(Bus):
    """Has one subscription to an event for all subscribers."""

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        await super().subscribe(component_ref, event_type, sink)
        return "engine/the one"


class Fussy(Bus):
    """Complains about subscriptions that are gone."""

    async def unsubscribe(self, subscribe_id: str) -> None:
        if subscribe_id not in self._subscriptions:
            raise BadParameter("there is no such subscription")
        await super().unsubscribe(subscribe_id)


class Volatile(Motor):
    """Forgets a value whenever it is looked at."""

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        if changes.get("label") == "text":
            self.speed += 1
            raise BadParameter("not this")
        return changes


@pytest.mark.parametrize(
    ("make", "rule"),
    [
        (Deaf, "what_is_set_is_told"),
        (Piecemeal, "it_refuses_parameters_that_do_not_fit"),
        (Secretive, "its_parameters_are_told"),
        (lambda: Bus(Volatile()), "what_is_set_is_told"),
        (OneEar, "its_events_can_be_subscribed"),
        (Fussy, "its_events_can_be_subscribed"),
    ],
)
async def test_a_store_or_an_event_that_is_not_in_order(make: Callable[[], LocalRegistry], rule: str) -> None:
    assert rule in await rules_broken(make())


async def test_a_component_without_a_profile() -> None:
    class Nameless(Bus):
        async def discover(self) -> Any:
            directory = await super().discover()
            directory.component_profiles.clear()  # type: ignore[attr-defined]
            return directory

    assert await rules_broken(Nameless()) == {"it_has_an_identity"}


# What a component in this process owes to its adapter.


class Numb(Motor):
    """Announces nothing."""

    def __setattr__(self, name: str, value: object) -> None:
        super().__setattr__(name, (lambda _kind, _results: None) if name == "emit" else value)


class Clinging(Motor):
    """Does not let go."""

    async def take_down(self) -> None: ...  # type: ignore[misc]


class OnceOnly(Motor):
    connections = 0

    async def connect(self) -> None:
        self.connections += 1
        if self.connections > 1:
            raise OSError("it can be connected once")


class Unreachable(Motor):
    async def connect(self) -> None:
        raise OSError("no such device")


@pytest.mark.parametrize(
    ("kind", "rule"),
    [
        (Numb, "events_are_heard_until_unsubscribed"),
        (Clinging, "it_lets_go"),
        (Clinging, "without_connection_it_only_keeps_parameters"),
        (OnceOnly, "it_comes_up_again"),
        (Unreachable, "its_queries_answer"),
    ],
)
async def test_a_component_that_its_adapter_cannot_work_with(kind: type[Motor], rule: str) -> None:
    class Contract(ComponentContract):
        patience = PATIENCE

        async def component(self) -> Component:
            return kind()

    (chosen,) = (each for each in (*RULES, *LOCAL_RULES) if each.__name__ == rule)
    with pytest.raises((AssertionError, RoISError)):
        await Contract().try_rule(chosen)


def test_one_that_cannot_be_ended_is_found_and_does_not_hang(monkeypatch: pytest.MonkeyPatch) -> None:
    class Stubborn(Motor):
        async def start(self) -> None:
            while True:
                try:
                    await asyncio.Event().wait()
                except asyncio.CancelledError:
                    continue

    class Contract(ComponentContract):
        patience = PATIENCE

        async def component(self) -> Component:
            return Stubborn()

    monkeypatch.setattr(message_rules, "ENDING", PATIENCE)
    with pytest.raises(AssertionError, match="let CancelledError pass, and clean up in `finally`"):
        Contract().test_stop_ends_start()  # type: ignore[attr-defined]
