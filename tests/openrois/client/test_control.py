"""Control: a lost connection is resumed, components change hands, and everything stops."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.client import (
    BindingLost,
    Client,
    Command,
    Connected,
    ConnectionLost,
    ControlChanged,
    ControlDeclined,
    ControlRequested,
    ControlStopped,
    ControlWithdrawn,
    resumption,
)
from openrois.errors import Aborted, ComponentFailed, OutOfResources, Unsupported
from openrois.gateway.applications import serve_application
from openrois.gateway.token_expiry import TokenExpiry
from openrois.journal.former import GATEWAY_LOST, FormerCommand
from openrois.journal.journal import NoJournal
from openrois.journal.sqlite_journal import SqliteJournal
from openrois.session.session import EngineHost
from openrois.transport.stream import StreamClosed
from openrois.types.leases import LeaseState
from tests.support import grounds
from tests.support.authorization import principal
from tests.support.grounds import Clock, Line

pytestmark = pytest.mark.extra(name="base")

LAMP = "toys/lamp"


@pytest.fixture
async def line() -> AsyncIterator[Line]:
    async with grounds.line(grace=10) as running:
        yield running


@pytest.fixture
async def ann(line: Line, clock: Clock) -> AsyncIterator[Client]:
    async with Client(dial=line.dial, reconnect=clock.reconnect()) as connected:
        yield connected


@pytest.fixture
async def bob(line: Line) -> AsyncIterator[Client]:
    async with Client(dial=line.dial) as connected:
        yield connected


async def heard(notices: AsyncIterator[Any]) -> Any:
    async with asyncio.timeout(60):
        return await anext(notices)


class TestResuming:
    async def test_what_ran_is_told_of(self, line: Line, clock: Clock, ann: Client) -> None:
        notices = ann.notices(Connected)
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        line.cut()
        await clock.pass_time()
        await heard(notices)
        assert not running.done
        line.lamp.may_end.set()
        await running

    async def test_what_ran_at_a_gateway_that_seemed_silent_is_told_of(
        self, line: Line, clock: Clock, ann: Client
    ) -> None:
        notices = ann.notices(Connected)
        await ann.bind(LAMP)
        epoch = (await ann.control.status(LAMP)).epoch
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        await line.leave(1011)
        await clock.pass_time()
        await heard(notices)
        assert (await ann.control.status(LAMP)).epoch == epoch
        line.lamp.may_end.set()
        await running

    async def test_what_ended_meanwhile_is_told_of(self, line: Line, clock: Clock, ann: Client) -> None:
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        line.cut()
        await clock.asleep()
        line.lamp.may_end.set()
        await clock.pass_time()
        await running

    async def test_no_other_application_gets_it_meanwhile(self, line: Line, clock: Clock, ann: Client) -> None:
        notices = ann.notices(Connected)
        await ann.bind(LAMP)
        line.cut()
        await clock.asleep()
        async with Client(dial=line.dial) as eve:
            with pytest.raises(OutOfResources):
                await eve.bind(LAMP)
            assert (await eve.control.status(LAMP)).state is LeaseState.ABSENT
            await clock.pass_time()
            await heard(notices)
            assert (await eve.control.status(LAMP)).state is LeaseState.HELD
            await ann.component(LAMP).command("switch", times=1)

    async def test_what_was_given_back_meanwhile_is_free(self, line: Line, clock: Clock, ann: Client) -> None:
        notices = ann.notices(Connected)
        async with ann.bound(LAMP):
            line.cut()
            await clock.asleep()
        await clock.pass_time()
        await heard(notices)
        async with Client(dial=line.dial) as eve:
            await eve.bind(LAMP)

    async def test_what_the_gateway_does_not_know_is_lost(self, line: Line, clock: Clock, ann: Client) -> None:
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        ann._application._resumption._token = "another"
        line.cut()
        await clock.pass_time()
        with pytest.raises(ConnectionLost):
            await running

    async def test_commands_of_a_session_that_is_not_resumed_fail_in_time(
        self, line: Line, clock: Clock, ann: Client, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        monkeypatch.setattr(resumption, "PATIENCE", 0.01)
        ann._application._resumption._grace = 0.01
        line.cut()
        with pytest.raises(ConnectionLost, match="1006"):
            await running
        await clock.pass_time()

    async def test_one_that_breaks_again_before_it_is_whole(self, line: Line, clock: Clock, ann: Client) -> None:
        """It had resumed the lost one, so that it is the one to resume now."""
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        usual = line.speaks

        async def breaks(host: EngineHost, stream: Any) -> None:
            receive = stream.receive

            async def until_it_binds() -> str:
                text: str = await receive()
                if "rois.command.bind" not in text:
                    return text
                stream.abort()
                raise StreamClosed(1006)

            stream.receive = until_it_binds
            await usual(host, stream)

        line.speaks = breaks
        line.cut()
        await clock.pass_time()
        await clock.asleep()
        line.speaks = usual
        line.lamp.may_end.set()
        await clock.pass_time()
        await running
        await ann.component(LAMP).command("switch", times=1)

    async def test_a_connection_that_the_gateway_takes_for_alive(self, line: Line, clock: Clock) -> None:
        """Only our end is gone at first: the gateway learns of it later."""
        notices: Any
        async with Client(dial=line.dial, reconnect=clock.reconnect()) as ann:
            notices = ann.notices(Connected)
            await ann.bind(LAMP)
            running = await ann.component(LAMP).command("start").execute()
            await line.lamp.glowing.wait()
            (far,) = line._ends
            near = far._other
            far._other, near._other = near, near
            near.abort()
            await clock.pass_time()
            await heard(notices)
            assert not running.done
            await ann.component(LAMP).command("switch", times=1)
            line.lamp.may_end.set()
            await running


async def test_a_session_that_another_one_has_resumed(line: Line, clock: Clock, ann: Client, bob: Client) -> None:
    """The client comes back with another subject, and does not fight: it is notified of what it has lost."""
    lost = ann.notices(BindingLost)
    await ann.bind(LAMP)
    running = await ann.component(LAMP).command("start").execute()
    await line.lamp.glowing.wait()
    token = (await ann.call("openrois.lease.token"))["token"]
    resumed = await bob.call("openrois.lease.resume", token=token, command_ids=[running.command_id])
    assert [lease["component_ref"] for lease in resumed["leases"]] == [LAMP]
    await clock.pass_time()
    assert (await heard(lost)).component_ref == LAMP
    with pytest.raises(ConnectionLost, match=r"4409.*; the gateway does not know of it"):
        await running
    assert (await ann.control.status(LAMP)).state is LeaseState.HELD
    line.lamp.may_end.set()
    await bob.component(LAMP).command("switch", times=1)


class TestRestart:
    """The gateway has crashed and is there again: it knows no session, but its journal knows commands."""

    async def test_each_command_gets_its_end(self, line: Line, clock: Clock, tmp_path: Path) -> None:
        async with restarted(line, tmp_path) as restart, Client(dial=line.dial, reconnect=clock.reconnect()) as ann:
            lamp = ann.component(LAMP)
            await lamp.bind()
            ended = await lamp.command("switch", times=2).execute()
            await ended
            running = await ann.execute(lamp.command("start"), lamp.command("switch", times=1))
            await line.lamp.glowing.wait()
            # Two whose ends were on their way when the gateway ended, and one that it never heard of.
            unheard = await lamp.command("switch", times=3).execute()
            failed = await lamp.command("fail").execute()
            for command in (unheard, failed):
                await command.wait()
                command._outcome = None
                command._ended.clear()
            stranger = Command("toys/lamp", "start", "never sent", lambda _command_id: unheard)
            ann._application.commands.expect((unheard, failed, stranger))
            await restart()
            await clock.pass_time()
            assert await unheard == {"total": 5}
            with pytest.raises(ComponentFailed, match="the bulb is gone"):
                await failed
            for command in running.commands:
                with pytest.raises(ComponentFailed, match="the gateway was restarted"):
                    await command
            with pytest.raises(ConnectionLost, match="the gateway does not know of it"):
                await stranger
            assert not len(ann._application.commands)
            assert await ended == {"total": 2}

    async def test_an_end_notified_to_a_lost_connection_is_lost(self, line: Line, clock: Clock, tmp_path: Path) -> None:
        """The first connection after the restart asks, and breaks before it hears the answer."""
        async with restarted(line, tmp_path) as restart, Client(dial=line.dial, reconnect=clock.reconnect()) as ann:
            await ann.bind(LAMP)
            running = await ann.component(LAMP).command("start").execute()
            await line.lamp.glowing.wait()
            await restart()
            await line.host.journal.deliver_outcome("local", running.command_id)
            await clock.pass_time()
            with pytest.raises(ConnectionLost, match="was notified over the lost connection, and never arrived"):
                await running

    async def test_without_a_token_too(self, clock: Clock, tmp_path: Path) -> None:
        async with (
            grounds.line(grace=0) as line,
            restarted(line, tmp_path) as restart,
            Client(dial=line.dial, reconnect=clock.reconnect()) as ann,
        ):
            await ann.bind(LAMP)
            running = await ann.component(LAMP).command("start").execute()
            await line.lamp.glowing.wait()
            await restart()
            await clock.pass_time()
            with pytest.raises(ComponentFailed, match="the gateway was restarted"):
                await running


class SlowJournal(NoJournal):
    """The journal of a gateway that was lost, which counts as running for a while."""

    def __init__(self, looks: int) -> None:
        super().__init__()
        self.looks = looks
        self._lost = FormerCommand(LAMP, None, GATEWAY_LOST, None)

    async def find(self, subject: str, command_id: str) -> FormerCommand | None:
        self.looks -= 1
        return replace(self._lost, is_running=self.looks >= 0)

    async def deliver_outcome(self, subject: str, command_id: str) -> FormerCommand | None:
        return self._lost


@pytest.mark.parametrize(("looks", "error"), [(0, ComponentFailed), (3, ComponentFailed), (99, ConnectionLost)])
async def test_the_end_of_a_command_at_a_gateway_that_may_be_lost_is_asked_for_again(
    looks: int,
    error: type[Exception],
    line: Line,
    clock: Clock,
    ann: Client,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("openrois.interfaces.command._LOOKS_ELSEWHERE", 1)
    monkeypatch.setattr("openrois.interfaces.command._LOOK_AGAIN", 1e-9)
    await ann.bind(LAMP)
    running = await ann.component(LAMP).command("start").execute()
    await line.lamp.glowing.wait()
    line.host = EngineHost(line.host.engine, line.tasks, journal=SlowJournal(looks), lease_rules=line.host.lease_rules)
    line.cut()
    await clock.pass_time()
    with pytest.raises(error, match=r"lost|another gateway"):
        await running


@asynccontextmanager
async def restarted(line: Line, folder: Path) -> AsyncIterator[Callable[[], Awaitable[None]]]:
    """Give a gateway a journal; what comes back lets it crash and be there again."""
    async with AsyncExitStack() as stack:
        journal = line.host.journal = stack.enter_context(SqliteJournal(folder / "journal"))

        async def restart() -> None:
            nonlocal journal
            journal.__exit__(None, None, None)
            line.cut()
            tasks = await stack.enter_async_context(TaskScope())
            journal = stack.enter_context(SqliteJournal(folder / "journal"))
            line.host = EngineHost(line.host.engine, tasks, journal=journal, lease_rules=line.host.lease_rules)

        yield restart


class TestHandover:
    async def test_granted(self, line: Line, ann: Client, bob: Client) -> None:
        told, lost = ann.notices(ControlRequested), ann.notices(BindingLost)
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        asking = asyncio.ensure_future(bob.control.request(LAMP))
        asked = await heard(told)
        assert (asked.component_ref, asked.subject, 0 < asked.within <= 30) == (LAMP, "local", True)
        await ann.control.grant(asked.request_id)
        await asking
        with pytest.raises(Aborted, match="handed it over"):
            await running
        assert (await heard(lost)).component_ref == LAMP
        await bob.component(LAMP).command("switch", times=1)
        with pytest.raises(OutOfResources):
            await ann.component(LAMP).command("switch", times=1)

    async def test_declined(self, ann: Client, bob: Client) -> None:
        told, declined, withdrawn = (
            ann.notices(ControlRequested),
            bob.notices(ControlDeclined),
            ann.notices(ControlWithdrawn),
        )
        await ann.bind(LAMP)
        asking = asyncio.ensure_future(bob.control.request(LAMP))
        asked = await heard(told)
        await ann.control.decline(asked.request_id)
        with pytest.raises(OutOfResources, match="its holder keeps it"):
            await asking
        assert (await heard(declined)).request_id == asked.request_id
        assert (await heard(withdrawn)).request_id == asked.request_id

    async def test_waiting_in_line(self, ann: Client, bob: Client) -> None:
        told, changed = ann.notices(ControlRequested), ann.notices(ControlChanged)
        await ann.bind(LAMP)
        asking = asyncio.ensure_future(bob.control.request(LAMP, wait=True))
        await ann.control.decline((await heard(told)).request_id)
        assert (await heard(changed)).waiting == 1
        await ann.release(LAMP)
        await asking
        assert (await ann.control.status(LAMP)).state is LeaseState.HELD

    @pytest.mark.parametrize("comes_back", [False, True])
    async def test_what_is_gone_is_waited_for_no_more(
        self, line: Line, ann: Client, bob: Client, comes_back: bool
    ) -> None:
        told = ann.notices(ControlRequested)
        await ann.bind(LAMP)
        asking = asyncio.ensure_future(bob.control.request(LAMP, wait=True))
        await heard(told)
        line.host.leases.end_all(line.host.engine.detach(line.toys))
        if comes_back:
            await line.host.engine.attach(line.toys)
        with pytest.raises((OutOfResources, Unsupported), match=r"request it again|there is no component"):
            await asyncio.wait_for(asking, 10)

    async def test_what_is_not_shown_any_more_is_waited_for_no_more(self, line: Line, ann: Client) -> None:
        told = ann.notices(ControlRequested)
        await ann.bind(LAMP)
        expiry = TokenExpiry(principal("operator", "toys/*"))
        line.speaks = partial(serve_application, expiry=expiry)
        async with Client(dial=line.dial) as carl:
            asking = asyncio.ensure_future(carl.control.request(LAMP, wait=True))
            await heard(told)
            expiry.replace(principal("operator", "toys/bell"))
            with pytest.raises(Unsupported, match="there is no component"):
                await asyncio.wait_for(asking, 10)

    async def test_a_free_one_and_one_that_is_no_actuation(self, ann: Client) -> None:
        await ann.control.request(LAMP)
        await ann.component(LAMP).command("switch", times=1)
        with pytest.raises(Unsupported):
            await ann.control.request("toys/bell")

    async def test_taken(self, ann: Client, bob: Client) -> None:
        lost = ann.notices(BindingLost)
        await ann.bind(LAMP)
        await bob.control.take(LAMP)
        assert "an administrator has taken it" in str((await heard(lost)).error)
        await bob.component(LAMP).command("switch", times=1)

    @pytest.mark.parametrize("overtaken", [False, True])
    async def test_a_request_that_has_no_answer_in_time_leaves_the_line(
        self, line: Line, bob: Client, monkeypatch: pytest.MonkeyPatch, overtaken: bool
    ) -> None:
        """Also where the gateway comes to it late, and hears first that it is given up."""
        goes_on = asyncio.Event()
        usual = line.speaks

        async def holds_back(host: EngineHost, stream: Any) -> None:
            receive, held = stream.receive, list[str]()

            async def later() -> str:
                if held:
                    await goes_on.wait()
                    return held.pop()
                text: str = await receive()
                if "openrois.lease.request" not in text:
                    return text
                held.append(text)
                return await (receive() if overtaken else later())

            stream.receive = later
            await usual(host, stream)

        await bob.bind(LAMP)
        told = bob.notices(ControlRequested, ControlWithdrawn)
        line.speaks = holds_back
        async with Client(dial=line.dial) as carl:
            monkeypatch.setattr(carl._connection, "request_timeout", 0.01)
            with pytest.raises(TimeoutError):
                await carl.control.request(LAMP)
            goes_on.set()
            asked = await heard(told)
            assert isinstance(asked, ControlRequested)
            assert await heard(told) == ControlWithdrawn(LAMP, asked.request_id)
            assert (await bob.control.status(LAMP)).waiting == 0

    async def test_a_request_that_fails_gives_back_nothing_that_was_bound(
        self, line: Line, ann: Client, bob: Client, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        await ann.bind(LAMP)
        monkeypatch.setattr(ann._connection, "request_timeout", 0)
        with pytest.raises(TimeoutError):
            await ann.control.request(LAMP)
        monkeypatch.undo()
        assert (await ann.control.status(LAMP)).state is LeaseState.MINE
        with pytest.raises(Unsupported):
            await bob.control.request("toys/none")
        assert (await bob.control.status(LAMP)).state is LeaseState.HELD

    async def test_an_application_that_leaves_does_not_wait(self, line: Line, ann: Client, bob: Client) -> None:
        await bob.bind(LAMP)
        told = bob.notices(ControlRequested)
        asking = asyncio.ensure_future(ann.control.request(LAMP))
        await heard(told)
        line.cut()
        with pytest.raises(ConnectionLost):
            await asking


async def test_stop(line: Line, ann: Client, bob: Client) -> None:
    await ann.bind(LAMP)
    running = await ann.component(LAMP).command("start").execute()
    await line.lamp.glowing.wait()
    assert LAMP in await bob.control.stop_all("toys")
    with pytest.raises(Aborted):
        await running
    assert LAMP in await ann.control.stop_all(component_ref=LAMP)
    with pytest.raises(Unsupported):
        await ann.control.stop_all("unknown")


async def test_what_does_not_stop_is_named(line: Line, ann: Client) -> None:
    async def fail() -> None:
        raise ComponentFailed("the switch is stuck")

    line.lamp.stop = fail  # type: ignore[method-assign]
    with pytest.raises(ComponentFailed, match=r"toys/lamp: .*stuck"):
        await ann.control.stop_all("toys")


@asynccontextmanager
async def client_of(line: Line, subject: str, rank: str) -> AsyncIterator[Client]:
    """Connect a client with a token of a rank."""
    who = TokenExpiry(principal("operator", "*", subject=subject, rank=rank))
    line.speaks = lambda host, stream: serve_application(host, stream, who)
    async with Client(dial=line.dial) as client:
        yield client


async def test_a_body_that_a_person_has_stopped(line: Line) -> None:
    async with client_of(line, "ann", "person") as ann, client_of(line, "agent", "agent") as agent:
        told = agent.notices(ControlStopped)
        await agent.bind(LAMP)
        await ann.control.stop_all("toys")
        waits = "toys was stopped by ann: programs wait until a person hands it back"
        stopped = await heard(told)
        assert stopped == ControlStopped("toys", "ann", waits, stopped.stop_id)
        with pytest.raises(OutOfResources, match=waits):
            await agent.component(LAMP).command("switch", times=1)
        assert (await agent.control.status(LAMP)).stopped_by == "ann"
        with pytest.raises(Unsupported, match="only a person hands back"):
            await agent.control.release_stop("toys")
        await ann.control.release_stop("toys")
        assert await heard(told) == ControlStopped(
            "toys", "", "toys was handed back to programs by ann", stopped.stop_id
        )
        await agent.component(LAMP).command("switch", times=1)
    assert line.lamp.total == 1


async def test_a_client_hands_back_the_stop_that_it_was_told(line: Line) -> None:
    async with client_of(line, "ann", "person") as ann, client_of(line, "bob", "person") as bob:
        await ann.control.stop_all("toys")
        assert (await ann.control.status(LAMP)).stopped_by == "ann"
        told = ann.notices(ControlStopped)
        # Told by hand, without the gateway: bob's STOP has not come to ann yet.
        line.host.stop_latch.latch("toys", "bob", "newer")
        with pytest.raises(OutOfResources, match="toys was stopped again meanwhile, by bob: hand it back anew"):
            await ann.control.release_stop("toys")
        assert line.host.stop_latch.by("toys") == "bob"
        await bob.control.stop_all("toys")
        assert (await heard(told)).by == "bob"
        await ann.control.release_stop("toys")
        assert line.host.stop_latch.by("toys") == ""
