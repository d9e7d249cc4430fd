"""Running the checks against a gateway, one after another, each with connections of its own."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

from websockets.exceptions import WebSocketException

from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.transport.websocket import refusal
from openrois.types.directory import DIRECTORY
from openrois.types.leases import LEASES
from openrois_conformance.application import Application
from openrois_conformance.deviation import Deviation
from openrois_conformance.door import door_to
from openrois_conformance.probe import Probe, dialled, new_engine_id
from openrois_conformance.probe_engine import ProbeEngine
from openrois_conformance.probe_profiles import component_profiles
from openrois_conformance.stage import Check, Needs, Setting, Stage, adapter_url
from openrois_conformance.transcript import Frame, Transcript

__all__ = ["Outcome", "Verdict", "Visit", "run_checks", "visit"]

_CHECK_TIMEOUT: Final = 60.0
"""Seconds after which a check is given up, beside ten of its waits."""


_WHOLE: Final = "a check that comes to its end"


class Outcome(Enum):
    """The result of a check."""

    PASSED = "pass"
    FAILED = "FAIL"
    NOT_RUN = "not run"


@dataclass(frozen=True, slots=True)
class Verdict:
    """The outcome of one check.

    Attributes:
        check: which.
        outcome: how it went.
        expected: what should have come, where it failed.
        came: what came, where it failed; why it was not run, where it was not.
        remarks: what a user should know although it passed.
        frames: what was said.
    """

    check: Check
    outcome: Outcome
    expected: str = ""
    came: str = ""
    remarks: tuple[str, ...] = ()
    frames: tuple[Frame, ...] = ()


@dataclass(frozen=True, slots=True)
class Visit:
    """A gateway that is being tried.

    Attributes:
        setting: what all checks share.
        engines: the ids of the gateway's engines, its own first, as they were before the suite came.
        missing: why checks with a need are not run.
    """

    setting: Setting
    engines: tuple[str, ...]
    missing: dict[Needs, str]


@asynccontextmanager
async def visit(
    url: str,
    patience: float,
    *,
    adapter: bool,
    component: str | None = None,
    credentials: Credentials = NO_CREDENTIALS,
    adapter_credentials: Credentials | None = None,
) -> AsyncIterator[Visit]:
    """Examine a gateway, and put the suite's adapter behind it while the block runs.

    Args:
        url: where applications connect.
        patience: seconds to wait for anything.
        adapter: whether the suite may dial in as an adapter.
        component: a component of another maker that may be tried.
        credentials: what the suite shows where it connects.
        adapter_credentials: what its adapters show, unless that is the same.

    Raises:
        ValueError: the file with the authorities cannot be used.
        Deviation: the gateway does not even answer connect and get_profile, or has no such component.
    """
    transcript = Transcript()
    applications = door_to(url, credentials)
    adapters = replace(applications, url=adapter_url(url), credentials=adapter_credentials or credentials)
    setting = Setting(applications, adapters, patience, transcript, component=component)
    missing = {} if component else {Needs.COMPONENT: Needs.COMPONENT.value}
    async with AsyncExitStack() as stack:
        engines, extensions, is_administrator = await _look(setting)
        setting = replace(setting, extensions=extensions)
        there = {
            Needs.EXTENSIONS: bool(extensions),
            Needs.ADAPTER: adapter,
            Needs.LEASES: LEASES in extensions,
            Needs.DIRECTORY: DIRECTORY in extensions,
            Needs.ADMINISTRATOR: is_administrator,
        }
        missing |= {need: need.value for need, is_there in there.items() if not is_there}
        if adapter:
            try:
                setting = replace(setting, probe=await _attach(setting, stack))
            except (Deviation, OSError, ValueError, WebSocketException, TimeoutError) as error:
                missing[Needs.ADAPTER] = f"the suite's adapter was not taken: {refusal(error)}"
        yield Visit(setting, engines, missing)


async def _look(setting: Setting) -> tuple[tuple[str, ...], tuple[str, ...], bool]:
    """Return the gateway's engines, its extensions, and whether the suite may take what others hold."""
    async with AsyncExitStack() as stack:
        app = await Stage(setting, stack).application()
        await app.granted("rois.system.connect")
        tree = await app.tree()
        refs = tree.component_refs()
        if setting.component is not None and setting.component not in refs:
            raise Deviation(f"the component {setting.component}", f"the components {', '.join(refs) or 'none'}")
        answer = await app.response(await app.begin("openrois.hello", version="1", extensions=[]))
        extensions = tuple(answer["result"].get("extensions", ())) if "result" in answer else ()
        return tree.engine_ids(), extensions, LEASES in extensions and await _is_administrator(app)


async def _is_administrator(app: Application) -> bool:
    """Tell whether a method of administrators is refused for its params, and not for the principal."""
    return "error" in await app.response(await app.begin("openrois.lease.take"))


async def _attach(setting: Setting, stack: AsyncExitStack) -> Probe:
    engine_id = new_engine_id()
    engine = ProbeEngine(engine_id, component_profiles(engine_id))
    opened = dialled(setting.adapters, setting.transcript, setting.patience, engine)
    probe = await stack.enter_async_context(opened)
    async with AsyncExitStack() as watching:
        try:
            await Stage(setting, watching).until_there(next(iter(engine.profiles)))
        except Deviation:
            if probe.is_open:
                raise
            code, reason = await probe.closed()
            raise Deviation("it to be taken", f"it was closed with {code} {reason}".rstrip()) from None
    return probe


async def run_checks(
    place: Visit, checks: Sequence[Check], report: Callable[[Verdict], None] = lambda _verdict: None
) -> list[Verdict]:
    """Run checks and return their verdicts.

    Args:
        place: the gateway.
        checks: which, in this order.
        report: called with each verdict as it comes.
    """
    verdicts: list[Verdict] = []
    for check in checks:
        verdict = await _run(place, check)
        report(verdict)
        verdicts.append(verdict)
    return verdicts


async def _run(place: Visit, check: Check) -> Verdict:
    reasons = [place.missing[need] for need in Needs if need in check.needs and need in place.missing]
    if reasons:
        return Verdict(check, Outcome.NOT_RUN, came=reasons[0])
    setting = place.setting
    setting.transcript.begin()
    if setting.probe is not None:
        if Needs.ADAPTER in check.needs and not setting.probe.is_open:
            code, reason = await setting.probe.closed()
            return Verdict(check, Outcome.FAILED, "the suite's adapter to stay connected", f"closed {code} {reason}")
        setting.probe.reset()
    verdict: Verdict | None = None
    try:
        async with AsyncExitStack() as stack:
            verdict = await _judged(check, Stage(setting, stack))
    except Exception as error:
        # What breaks while connections are closed is this check's, and never the end of the run.
        if verdict is None or verdict.outcome is Outcome.PASSED:
            verdict = Verdict(check, Outcome.FAILED, _WHOLE, repr(error))
    return replace(verdict, frames=tuple(setting.transcript.frames))


async def _judged(check: Check, stage: Stage) -> Verdict:
    try:
        async with asyncio.timeout(_CHECK_TIMEOUT + 10 * stage.patience):
            await check.play(stage)
            await stage.strike()
        return Verdict(check, Outcome.PASSED, remarks=tuple(dict.fromkeys(stage.remarks)))
    except Deviation as deviation:
        return Verdict(check, Outcome.FAILED, deviation.expected, deviation.came)
    except TimeoutError:
        return Verdict(check, Outcome.FAILED, "an end of the check", "none")
    except (KeyError, IndexError, TypeError, ValueError) as error:
        return Verdict(check, Outcome.FAILED, "an answer that the check can follow", repr(error))
    except WebSocketException as error:
        return Verdict(check, Outcome.FAILED, "a connection that lasts", str(error))
    except Exception as error:
        return Verdict(check, Outcome.FAILED, _WHOLE, repr(error))
    finally:
        await stage.clear()
