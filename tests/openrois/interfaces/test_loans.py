"""Parts over the wire: they change hands whole, go to those of higher rank for a time, and come back."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.token_expiry import TokenExpiry
from openrois.observability.audit import Audit
from openrois.session.session import EngineHost
from tests.support.authorization import Place, Wire, principal
from tests.support.components import Lamp

WALK, DRIVE = {"component_ref": "robot/walk"}, {"component_ref": "robot/drive"}
Login = Callable[..., AbstractAsyncContextManager[Wire]]


class Walk(Lamp, code="Walk", part="legs"):
    """Walks until it may end."""


class Drive(Lamp, code="Drive", part="legs"):
    """Drives until it may end."""


class Recorded(Audit):
    """An audit trail that is kept in a list."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[tuple[str, str, str, str]] = []

    def acted(self, principal: Any, method: str, target: str = "", detail: str = "") -> None:
        self.lines.append((principal.subject, method, target, detail))


@pytest.fixture
async def here() -> AsyncIterator[Place]:
    engine = Engine("gateway")
    await engine.attach(LocalRegistry("robot", (Walk("walk"), Drive("drive"), Lamp())))
    async with TaskScope() as tasks:
        yield Place(EngineHost(engine, tasks, audit=Recorded()), {})


@pytest.fixture
def login(here: Place) -> Login:
    def application(subject: str, rank: str) -> AbstractAsyncContextManager[Wire]:
        return here.application(principal("operator", "*", subject=subject, rank=rank))

    return application


def script(login: Login) -> AbstractAsyncContextManager[Wire]:
    return login("night watch", "script")


def person(login: Login) -> AbstractAsyncContextManager[Wire]:
    return login("ann", "person")


async def execute(app: Wire, command_type: str, command_id: str, component_ref: str = "robot/walk") -> str | int:
    unit = {"component_ref": component_ref, "command_type": command_type, "command_id": command_id}
    return await app.code("rois.command.execute", {"command_unit_list": [unit]})


async def holds(app: Wire, component_ref: str = "robot/walk") -> dict[str, Any]:
    return await app.until(
        "openrois.lease.changed", lambda lease: (lease["component_ref"], lease["state"]) == (component_ref, "MINE")
    )


async def test_all_of_a_part_has_one_holder(login: Login) -> None:
    async with script(login) as app, login("bob", "script") as other:
        lease = (await app.result("openrois.lease.request", WALK))["lease"]
        assert (lease["state"], lease["part"], lease["return_ms"]) == ("MINE", "legs", 0)
        assert (await holds(app, "robot/drive"))["part"] == "legs"
        assert await execute(app, "switch", "c1", "robot/drive") == "OK"
        assert await other.code("rois.command.bind", DRIVE) == "OUT_OF_RESOURCES"
        assert await other.code("rois.command.bind", {"component_ref": "robot/lamp"}) == "OK"
        assert await app.code("rois.command.release", WALK) == "OK"
        assert await other.code("rois.command.bind", DRIVE) == "OK"
        # Its other components are not free to others, though no application has named them.
        assert (await app.result("openrois.lease.query", WALK))["lease"]["state"] == "HELD"
        assert (await other.result("openrois.lease.query", WALK))["lease"]["state"] == "FREE"


async def test_a_person_takes_a_part_for_a_time_and_it_comes_back(here: Place, login: Login) -> None:
    async with script(login) as app, person(login) as ann:
        first = (await app.result("openrois.lease.request", WALK))["lease"]["epoch"]
        assert await execute(app, "start", "walking") == "OK"
        lease = (await ann.result("openrois.lease.borrow", {**WALK, "duration_ms": 20_000}))["lease"]
        assert (lease["state"], lease["lender"], lease["return_position"]) == ("MINE", "night watch", 0)
        assert 0 < lease["return_ms"] <= 20_000
        # What was taken, by whom, and until when.
        told = await app.until("openrois.lease.changed", lambda each: each["component_ref"] == "robot/walk")
        assert (told["state"], told["holder"], told["return_position"]) == ("HELD", "ann", 1)
        assert 0 < told["return_ms"] <= 20_000
        assert await app.completed("walking") == "ABORT"
        assert await execute(app, "switch", "refused") == "OUT_OF_RESOURCES"
        refusal = await app.until("openrois.reason")
        assert "was taken for a time by ann, and comes back in" in refusal["reason"]
        assert await execute(ann, "switch", "hers", "robot/drive") == "OK"
        assert await ann.code("openrois.lease.give_back", DRIVE) == "OK"
        assert (await holds(app))["epoch"] > lease["epoch"] > first
        assert await execute(app, "switch", "again") == "OK"
        assert await execute(ann, "switch", "late") == "OUT_OF_RESOURCES"
        lines = here.host.audit.lines  # type: ignore[attr-defined]
        done = [line[:3] for line in lines if line[2] == "robot/walk" and not line[1].startswith("rois")]
        assert ("ann", "openrois.lease.borrow", "robot/walk") in done
        assert ("night watch", "lease.lost", "robot/walk") in done
        assert ("night watch", "lease.gained", "robot/walk") in done


@pytest.mark.parametrize("how", ["given back", "over", "borrower lost", "lender left", "STOP"])
async def test_the_audit_trail_has_each_loan_and_how_it_ended(here: Place, login: Login, how: str) -> None:
    async with script(login) as app, AsyncExitStack() as gone:
        ann = await gone.enter_async_context(person(login))
        await app.code("openrois.lease.request", WALK)
        duration = 1 if how == "over" else 60_000
        await ann.code("openrois.lease.borrow", {**WALK, "duration_ms": duration})
        match how:
            case "given back":
                await ann.code("openrois.lease.give_back", WALK)
            case "borrower lost":
                await gone.aclose()
            case "lender left":
                await app.code("rois.system.disconnect", {})
                await ann.code("openrois.lease.give_back", WALK)
            case "STOP":
                await ann.code("openrois.stop_all", WALK)
                await ann.code("openrois.lease.give_back", WALK)
        if how in ("given back", "over", "borrower lost"):
            await holds(app)
    lines = [
        (who, method, detail.partition(": ")[2] if method.startswith("lease.") else detail)
        for who, method, subject, detail in here.host.audit.lines  # type: ignore[attr-defined]
        if subject in ("robot", "robot/walk")
    ]
    script_lost, back = ("night watch", "lease.lost", "lent"), ("night watch", "lease.gained", "returned")
    borrowed = [
        ("night watch", "openrois.lease.request", ""),
        ("ann", "openrois.lease.borrow", ""),
        script_lost,
        ("ann", "lease.gained", "lent"),
    ]
    given_back = ("ann", "openrois.lease.give_back", "")
    ended = {
        "given back": [back, given_back],
        "over": [("ann", "lease.lost", "due"), back],
        "borrower lost": [("ann", "lease.lost", "left"), back],
        "lender left": [given_back],
        "STOP": [
            ("ann", "openrois.stop_all", "programs wait"),
            ("night watch", "lease.not_returned", "latched"),
            given_back,
        ],
    }
    assert lines[: len(borrowed) + len(ended[how])] == [*borrowed, *ended[how]]


async def test_equals_and_those_of_lower_rank_ask(login: Login) -> None:
    async with person(login) as ann, login("eve", "person") as eve, login("guide", "agent") as guide:
        await ann.code("openrois.lease.request", WALK)
        for other in (eve, guide):
            assert await other.code("openrois.lease.borrow", DRIVE) == "OUT_OF_RESOURCES"
            refusal = await other.until("openrois.reason")
            assert "robot/drive is held by ann" in refusal["reason"]
            assert "request it instead" in refusal["reason"]
            assert (await other.result("openrois.lease.request", DRIVE))["lease"]["position"] > 0


async def test_it_comes_back_at_its_time(login: Login) -> None:
    async with login("guide", "agent") as guide, person(login) as ann:
        await guide.code("openrois.lease.request", WALK)
        assert await ann.code("openrois.lease.borrow", {**WALK, "duration_ms": 1}) == "OK"
        assert (await holds(guide))["reason"].startswith("it has come back")
        lost = await ann.until("openrois.lease.changed", lambda each: each["state"] == "HELD")
        assert lost["holder"] == "guide"


async def test_it_comes_back_when_the_borrower_is_gone(login: Login) -> None:
    async with script(login) as app:
        await app.code("openrois.lease.request", WALK)
        async with person(login) as ann:
            await ann.code("openrois.lease.token", {})
            await ann.code("openrois.lease.borrow", WALK)
        await holds(app)


async def test_for_one_command_it_comes_back_with_the_end_of_that(here: Place, login: Login) -> None:
    walk = here.host.engine.components["robot/walk"]
    assert walk.part == "legs"
    async with script(login) as app, person(login) as ann:
        await app.code("openrois.lease.request", WALK)
        await ann.code("openrois.lease.borrow", {**WALK, "ends_with": "COMMAND"})
        assert await execute(ann, "switch", "prepared") == "OK"
        assert await ann.completed("prepared") == "OK"
        assert await execute(ann, "start", "walking") == "OK"
        assert await execute(ann, "stop", "enough") == "OK"
        assert await ann.completed("walking") == "ABORT"
        await holds(app)


async def test_a_lender_that_may_not_see_it_any_more_gives_up_its_place(here: Place, login: Login) -> None:
    bob = TokenExpiry(principal("operator", "*", subject="bob", rank="script"))
    async with here.application(bob) as app, person(login) as ann:
        await app.code("openrois.lease.request", WALK)
        await ann.code("openrois.lease.borrow", WALK)
        bob.replace(principal("operator", "rover/*", subject="bob", rank="script"))
        await ann.code("openrois.lease.give_back", WALK)
        assert here.host.leases.model.holding.held() == frozenset()


@pytest.mark.parametrize("params", [{"duration_ms": 0}, {"duration_ms": 600_001}, {"ends_with": "NEVER"}])
async def test_what_is_no_loan_is_refused(login: Login, params: dict[str, Any]) -> None:
    async with person(login) as ann:
        assert await ann.code("openrois.lease.borrow", {**WALK, **params}) == -32602
