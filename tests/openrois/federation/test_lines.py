"""Lines of sessions at one gateway: what they hold is written, and kept for them at the next owner."""

from collections.abc import AsyncIterator, Mapping
from hashlib import sha256
from types import SimpleNamespace
from typing import Any, cast

import pytest

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Unsupported
from openrois.federation.lines import Lines, SessionLine, new_line
from openrois.federation.resumption import MAX_USED, Resumption
from openrois.leases.changes import Why
from openrois.leases.lease_notifications import session_of
from openrois.leases.tokens import new_token
from openrois.resumption.holdings_writer import HoldingsWriter
from openrois.resumption.lines import Holding
from openrois.resumption.memory_store import MemoryResumeStore
from openrois.session.session import ApplicationSession, EngineHost
from openrois.types.codes import CompletedStatus
from tests.support.components import Lamp

LAMP = "robot/lamp"


class Place:
    """A gateway with a robot, its lines, and the store."""

    def __init__(self, host: EngineHost, writer: HoldingsWriter, store: MemoryResumeStore) -> None:
        self.host = host
        self.writer = writer
        self.store = store
        self.lines = Lines(host, writer)

    def session(self) -> ApplicationSession:
        return ApplicationSession(self.host, lambda _method, _params, **_more: None)

    async def held(self) -> dict[str, str]:
        """Return the line of each component that the store knows as held."""
        assert await self.writer.flushed()
        return {each.component_ref: each.line_id for each in await self.store.held(["robot"])}


@pytest.fixture
async def place() -> AsyncIterator[Place]:
    store = MemoryResumeStore(lambda: 0.0)
    async with TaskScope() as tasks, HoldingsWriter(store) as writer:
        engine = Engine("gateway")
        await engine.attach(LocalRegistry("robot", [Lamp()]))
        for number, line_id in enumerate(("one", "two")):
            await store.issue(line_id, 0, "local", bytes([number]) * 32)
        yield Place(EngineHost(engine, tasks), writer, store)


async def test_what_a_line_holds_is_written_and_freed(place: Place) -> None:
    app = place.session()
    place.host.leases.bind(LAMP, app)
    assert await place.held() == {}, "it has no line yet"
    place.lines.adopt(app, SessionLine("one"))
    assert await place.held() == {LAMP: "one"}
    place.host.leases.release(LAMP, app)
    assert await place.held() == {}
    place.host.leases.bind(LAMP, app)
    assert await place.held() == {LAMP: "one"}


async def test_what_is_lent_stays_its_lenders_in_the_store(place: Place) -> None:
    app, borrower = place.session(), place.session()
    place.lines.adopt(app, SessionLine("one"))
    place.lines.adopt(borrower, SessionLine("two"))
    place.host.leases.bind(LAMP, app)
    await place.host.leases.borrow(LAMP, borrower, 60, for_one=False)
    assert await place.held() == {LAMP: "one"}
    # Another connection of each changes nothing of it.
    again, after = place.session(), place.session()
    place.lines.adopt(after, SessionLine("two", 1))
    place.lines.adopt(again, SessionLine("one", 1))
    assert place.host.leases.is_held(LAMP, after)
    assert await place.held() == {LAMP: "one"}
    place.host.leases.release(LAMP, after)
    assert place.host.leases.model.holding.is_held(LAMP, again)
    assert await place.held() == {LAMP: "one"}
    await place.host.leases.borrow(LAMP, after, 60, for_one=False)
    place.host.leases.release(LAMP, again)
    assert await place.held() == {}, "the lender has given it up"


async def test_the_holder_of_a_component_that_has_gone_is_kept(place: Place) -> None:
    app = place.session()
    place.lines.adopt(app, SessionLine("one"))
    place.host.leases.bind(LAMP, app)
    place.host.leases.end_all([LAMP])
    assert place.host.leases.carrier.ended == {Why.GONE: 1}
    assert await place.held() == {LAMP: "one"}


async def test_a_later_session_goes_on_in_the_place_of_a_former_one(place: Place) -> None:
    former, app = place.session(), place.session()
    place.lines.adopt(former, SessionLine("one", 1))
    place.host.leases.bind(LAMP, former)
    await former.close(lost=True)
    place.lines.adopt(app, SessionLine("one", 2))
    assert place.host.leases.is_held(LAMP, app)
    assert place.lines.session_of("one") is app
    late = place.session()
    with pytest.raises(Unsupported, match="resumed by another connection since"):
        place.lines.adopt(late, SessionLine("one", 1))
    assert place.host.leases.is_held(LAMP, app)


async def test_what_was_held_at_another_gateway_is_reserved(place: Place) -> None:
    place.lines.await_engines(
        [Holding(LAMP, "robot", "one", 5, "local"), Holding("arm/hand", "arm", "one", 5, "local")]
    )
    place.lines.restore(["robot"])
    other, app = place.session(), place.session()
    assert place.host.leases.is_held_by_another(LAMP, other)
    place.lines.adopt(app, SessionLine("one"))
    assert place.host.leases.is_held(LAMP, app)
    assert await place.held() == {LAMP: "one"}


async def test_what_is_reserved_has_the_rank_of_the_session_that_held_it(place: Place) -> None:
    place.lines.await_engines([Holding(LAMP, "robot", "one", 5, "helper", "agent")])
    place.lines.restore(["robot"])
    holder = place.host.leases.model.holding.holder(LAMP)
    assert holder is not None
    assert session_of(holder[0]).principal.rank == "agent"


async def test_a_session_that_is_there_already_has_it_at_once(place: Place) -> None:
    app = place.session()
    place.lines.adopt(app, SessionLine("one"))
    place.lines.await_engines([Holding(LAMP, "robot", "one", 5, "local")])
    place.lines.restore(["robot"])
    assert place.host.leases.is_held(LAMP, app)


async def test_nothing_is_taken_from_a_session_that_was_faster(place: Place) -> None:
    fast = place.session()
    place.host.leases.bind(LAMP, fast)
    place.lines.await_engines([Holding(LAMP, "robot", "one", 5, "local")])
    place.lines.restore(["robot"])
    assert place.host.leases.is_held(LAMP, fast)


def test_lines_are_not_guessed() -> None:
    assert len({new_line().line_id for _ in range(100)}) == 100
    assert len(new_line().line_id) == 32


def test_engines_are_looked_for_at_their_next_gateway_up_to_a_bound() -> None:
    tree = SimpleNamespace(has_engine=lambda _engine_id: False)
    routes = SimpleNamespace(line=SessionLine("one"), engine=SimpleNamespace(tree=tree))
    resumption = Resumption(cast(Any, routes))
    for number in range(MAX_USED + 1):
        resumption.note_use(f"engine-{number}/lamp")
    resumption.find_again([f"engine-{number}" for number in range(MAX_USED + 1)])
    assert len(resumption._missed) == MAX_USED
    assert "engine-0" not in resumption._missed


async def test_a_command_that_ends_while_other_gateways_are_asked_has_one_end(place: Place) -> None:
    told: list[str] = []

    def session() -> ApplicationSession:
        def notify(method: str, params: Mapping[str, Any], **_more: bool) -> None:
            if method == "rois.command.completed":
                told.append(params["command_id"])

        return ApplicationSession(place.host, notify)

    former, app = session(), session()
    place.lines.adopt(former, SessionLine("one"))
    former.commands.accept({"early": LAMP, "late": LAMP}, 0, text=0, subject=None)

    def end(command_id: str) -> None:
        former.commands.finish(command_id, (), CompletedStatus.OK, "")
        former.completed(command_id, CompletedStatus.OK)

    await former.close(lost=True)
    end("early")
    told.clear()
    token = new_token()
    await place.store.issue("one", 0, app.principal.subject, sha256(token.encode()).digest())

    async def ask_others(_gateway_id: str) -> Any:
        end("late")
        raise Unsupported("it is not there")

    federation = SimpleNamespace(
        lines=place.lines,
        resume_store=place.store,
        others=("b",),
        is_joined=True,
        counts=SimpleNamespace(resumptions={"whole": 0, "partial": 0}),
        keep_alive=lambda _line_id, _resumption: None,
    )
    routes = SimpleNamespace(
        app=app,
        federation=federation,
        line=SessionLine("one", 1),
        subs=SimpleNamespace(to=ask_others),
        work=SimpleNamespace(running=0),
    )
    reply = await Resumption(cast(Any, routes))._resume({"token": token, "command_ids": ["early", "late"]})
    assert (reply.result.forgotten, told) == ((), ["late"])
    reply.then()
    assert told == ["late", "early"]
