"""The contract that every component keeps, tried on one component, or on all that are behind a bus."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Final

from openrois.component.component import Component
from openrois.contract import Client, ComponentBus
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Unsupported
from openrois.leases.lease_notifications import notify_holder
from openrois.testing import life_rules, message_rules, parameter_rules, profile_rules
from openrois.testing.subject import Broken, EventCollector, LocalSubject, Subject
from openrois.types.references import reference
from openrois.types.streams import HolderNotification

__all__ = ["ComponentContract", "Finding", "findings"]

Rule = Callable[[Subject], Awaitable[None]]
LocalRule = Callable[[LocalSubject], Awaitable[None]]

RULES: Final[tuple[Rule, ...]] = (
    profile_rules.it_has_an_identity,
    profile_rules.its_profile_can_be_read,
    profile_rules.its_profile_keeps_to_its_type,
    profile_rules.it_has_the_commands_of_its_type,
    message_rules.it_tells_its_status,
    message_rules.its_queries_answer,
    message_rules.it_refuses_unknown_messages,
    message_rules.it_refuses_arguments_that_it_does_not_take,
    message_rules.stop_ends_start,
    message_rules.a_new_start_ends_the_former,
    message_rules.it_pauses_and_goes_on,
    parameter_rules.its_parameters_are_told,
    parameter_rules.what_is_set_is_told,
    parameter_rules.it_refuses_parameters_that_do_not_fit,
    message_rules.its_events_can_be_subscribed,
)
"""Rules that can be tried on any component, wherever it is."""

LOCAL_RULES: Final[tuple[LocalRule, ...]] = (
    life_rules.events_are_heard_until_unsubscribed,
    life_rules.without_connection_it_only_keeps_parameters,
    life_rules.it_lets_go,
    life_rules.it_comes_up_again,
)
"""Rules that can be tried on a component in this process."""


class ComponentContract:
    """The contract as test methods, each on a component of its own:

        class TestLamp(ComponentContract):
            async def component(self) -> Lamp:
                return Lamp("lamp")

    Attributes:
        parameters: what has to be set before `start`, as texts by name.
        refuses: messages that the component always refuses, and why.
        patience: seconds that an answer may take.
    """  # noqa: D415 - the sentence ends in the example

    parameters: Mapping[str, str] = {}
    refuses: Mapping[str, str] = {}
    patience: float = 5.0

    async def component(self) -> Component:
        """Return a new component, as an adapter would be given it, before it is connected."""
        raise NotImplementedError(f"{type(self).__name__} says in `async def component(self)` what is tried")

    async def try_rule(self, rule: LocalRule) -> None:
        """Try one rule on a new component.

        Raises:
            AssertionError: it is broken; the text says how.
        """
        component = await self.component()
        registry = LocalRegistry("engine", [component])
        subject = LocalSubject(
            bus=registry,
            component_ref=reference("engine", component.profile.name),
            profile=component.profile,
            parameters=self.parameters,
            refuses=self.refuses,
            patience=self.patience,
            component=component,
        )
        try:
            if not await subject.within("connect", component.bring_up()):
                raise Broken("connect failed; the log says why")
            await rule(subject)
        except BaseException:
            # The first error is the one to raise.
            with suppress(Broken):
                await subject.within("disconnect", component.take_down())
            raise
        await subject.within("disconnect", component.take_down())


def _test(rule: LocalRule) -> Callable[[ComponentContract], None]:
    def test(self: ComponentContract) -> None:
        # asyncio.run would wait for ever for a component that does not end.
        loop = asyncio.new_event_loop()
        try:
            loop.run_until_complete(self.try_rule(rule))
        finally:
            left = asyncio.all_tasks(loop)
            for task in left:
                task.cancel()
            if left:
                loop.run_until_complete(asyncio.wait(left, timeout=self.patience))
            loop.close()

    test.__doc__ = rule.__doc__
    return test


def _add_tests(rules: tuple[LocalRule, ...]) -> None:
    for rule in rules:
        setattr(ComponentContract, f"test_{_name(rule)}", _test(rule))


def _name(rule: LocalRule) -> str:
    return str(getattr(rule, "__name__", rule))


_add_tests((*RULES, *LOCAL_RULES))


@dataclass(frozen=True, slots=True)
class Finding:
    """One violation of the contract.

    Attributes:
        component_ref: whose it is; empty for the engine's.
        rule: the name of what was tried.
        sentence: what happened.
    """

    component_ref: str
    rule: str
    sentence: str


async def findings(
    bus: ComponentBus,
    *,
    parameters: Mapping[str, Mapping[str, str]] | None = None,
    refuses: Mapping[str, Mapping[str, str]] | None = None,
    patience: float = 5.0,
) -> list[Finding]:
    """Try every component behind a bus, and return the violations.

    A bus is, for one, the engine of a gateway with a whole adapter behind it. The components are started and stopped:
    what they move has to be free to move.

    Args:
        bus: what is tried.
        parameters: what has to be set before `start`, as texts by name, by component_ref.
        refuses: messages that a component always refuses, and why, by component_ref.
        patience: seconds that an answer may take.

    Raises:
        RoISError: the bus cannot say what is behind it.
        ValueError: `parameters` or `refuses` name a component that is not there.
    """
    directory = await bus.discover()
    refs = directory.profile.component_refs()
    for name, given in (("parameters", parameters), ("refuses", refuses)):
        if unknown := sorted(set(given or ()) - set(refs)):
            raise ValueError(f"{name} names {unknown[0]!r}, which is not there: there are {', '.join(refs) or 'none'}")
    found = [Finding("", "it_refuses_unknown_components", sentence) for sentence in await _strangers(bus, patience)]
    for component_ref in refs:
        profile = directory.component_profiles.get(component_ref)
        if profile is None:
            found.append(Finding(component_ref, "it_has_an_identity", "it is listed and has no profile"))
            continue
        needs = (parameters or {}).get(component_ref, {})
        subject = Subject(
            bus=bus,
            component_ref=component_ref,
            profile=profile,
            parameters=needs,
            refuses=(refuses or {}).get(component_ref, {}),
            patience=patience,
        )
        async with _held(bus, component_ref):
            for rule in RULES:
                try:
                    await rule(subject)
                except Broken as error:
                    found.append(Finding(component_ref, _name(rule), str(error)))
                except Exception as error:
                    # Whatever the bus raises, the others are still to be tried.
                    found.append(Finding(component_ref, _name(rule), f"{type(error).__name__}: {error}"))
    return found


@asynccontextmanager
async def _held(bus: ComponentBus, component_ref: str) -> AsyncIterator[None]:
    """Hold a component as its first client: a component with a dead man's switch moves for no other."""
    if not isinstance(bus, Engine):
        yield
        return
    tester = Client("tester", lambda _method, _params: None)
    notice = HolderNotification(component_ref=component_ref, holds=True, epoch=1)
    await notify_holder(bus, notice, tester)
    try:
        yield
    finally:
        await notify_holder(bus, notice.model_copy(update={"holds": False}), tester)
        await bus.extension.forget_client(tester)


async def _strangers(bus: ComponentBus, patience: float) -> list[str]:
    """Return the violations of a bus in refusing components that it does not have."""
    directory = await bus.discover()
    engine_id = directory.profile.identifier.code
    profile = next(iter(directory.component_profiles.values()), None)
    if profile is None:
        return []
    wrong: list[str] = []
    for ref in (reference(engine_id, "no such component"), "no such engine/lamp", ""):
        subject = Subject(bus=bus, component_ref=ref, profile=profile, patience=patience)
        for doing, work in (
            (f"a query of {ref!r}", bus.query(ref, "component_status")),
            (f"a command of {ref!r}", bus.invoke(ref, "start")),
            (f"a subscription to {ref!r}", bus.subscribe(ref, "event", EventCollector())),
        ):
            try:
                await subject.refused(doing, work, Unsupported)
            except Broken as error:
                wrong.append(str(error))
    return wrong
