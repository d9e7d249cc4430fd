import asyncio
import logging
from collections.abc import AsyncIterator

import pytest
from openrois_streaming.aiortc_internals.trial import UnsupportedLibrary
from openrois_streaming.errors import TooManySessions, UnknownPeer, UnknownStream
from openrois_streaming.network.session_limits import SessionLimits
from openrois_streaming.session import sessions as sessions_module
from openrois_streaming.session.session import StreamSession
from openrois_streaming.session.sessions import StreamSessions
from openrois_streaming.state import Party

from tests.support.streaming import settle
from tests.support.viewing import Application, FedPublisher, WirelessConnection


@pytest.fixture
async def sessions(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[StreamSessions]:
    WirelessConnection.stand_in(monkeypatch)
    async with StreamSessions(lambda client_id: Application().session, SessionLimits(2, 0)) as sessions:
        yield sessions
    assert len(sessions) == 0
    assert all(connection.closed for connection in WirelessConnection.made)


def connect(session: StreamSession, stream_id: str) -> None:
    session.connect(stream_id, "engine/Video", FedPublisher(), "video")


async def test_a_client_has_one_session_and_reaches_no_other(sessions: StreamSessions) -> None:
    alice, bob = sessions.open("alice"), sessions.open("bob")
    assert sessions.open("alice") is alice is not bob
    connect(alice, "a")
    connect(bob, "b")
    peer = alice.peer_ids[0]
    assert sessions.with_stream("alice", "a") is alice
    assert sessions.with_peer("alice", peer) is alice
    refusals = set()
    for client_id, stream_id in (("alice", "b"), ("alice", "z"), ("mallory", "a")):
        with pytest.raises(UnknownStream) as refusal:
            sessions.with_stream(client_id, stream_id)
        refusals.add(str(refusal.value))
    for client_id, peer_id in (("alice", "engine/p9"), ("mallory", peer)):
        with pytest.raises(UnknownPeer):
            sessions.with_peer(client_id, peer_id)
    assert len(refusals) == 1


async def test_the_number_of_clients_is_bounded(sessions: StreamSessions) -> None:
    connect(sessions.open("alice"), "a")
    connect(sessions.open("bob"), "b")
    with pytest.raises(TooManySessions):
        sessions.open("carol")
    await sessions.close("bob", "gone")
    await sessions.close("bob", "gone")
    assert sessions.open("carol")


async def test_a_session_closes_to_its_end_though_its_caller_gives_up(
    sessions: StreamSessions, monkeypatch: pytest.MonkeyPatch
) -> None:
    goes_on = asyncio.Event()

    async def close(connection: WirelessConnection) -> None:
        await goes_on.wait()
        connection.closed = True

    monkeypatch.setattr(WirelessConnection, "close", close)
    before = asyncio.all_tasks()
    connect(sessions.open("alice"), "a")
    await settle()
    closing = asyncio.ensure_future(sessions.close("alice", "gone"))
    await settle()
    closing.cancel()
    ending = asyncio.ensure_future(sessions.aclose("the engine stops"))
    await settle()
    assert not ending.done()
    goes_on.set()
    await ending
    assert {task for task in asyncio.all_tasks() - before if not task.done()} == set()


class Applications:
    """Applications by their client ids, with sessions of one engine on one clock."""

    def __init__(self, rules: SessionLimits) -> None:
        self.made: dict[str, Application] = {}
        self.sessions = StreamSessions(self._make, rules)

    def _make(self, client_id: str) -> StreamSession:
        self.made[client_id] = Application()
        return self.made[client_id].session

    async def comes(self, client_id: str, *, may_bind: bool = False, answers: bool = False) -> None:
        connect(self.sessions.open(client_id, may_bind=may_bind), client_id)
        await settle()
        if answers:
            await self.made[client_id].answer()

    async def later(self, seconds: float) -> None:
        for application in self.made.values():
            await application.clock.advance(seconds)


@pytest.fixture
async def applications(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Applications]:
    WirelessConnection.stand_in(monkeypatch)
    applications = Applications(SessionLimits(applications=4, kept_for_operators=2, answer_time=2.0))
    async with applications.sessions:
        yield applications


async def test_places_are_kept_for_those_that_may_bind(applications: Applications) -> None:
    for viewer in ("viewer 1", "viewer 2"):
        await applications.comes(viewer, answers=True)
    with pytest.raises(TooManySessions):
        await applications.comes("viewer 3")
    for operator in ("operator 1", "operator 2"):
        await applications.comes(operator, may_bind=True, answers=True)
    with pytest.raises(TooManySessions, match="all 4 places"):
        await applications.comes("operator 3", may_bind=True)
    await applications.sessions.close("viewer 1", "gone")
    await applications.comes("viewer 3")


async def test_an_application_that_may_bind_by_now_needs_no_place_of_those_that_may_not(
    applications: Applications,
) -> None:
    for viewer in ("viewer 1", "viewer 2"):
        await applications.comes(viewer, answers=True)
    applications.sessions.open("viewer 1", may_bind=True)
    await applications.comes("viewer 3", answers=True)
    applications.sessions.open("viewer 1", may_bind=False)
    with pytest.raises(TooManySessions):
        await applications.comes("viewer 4")


async def test_unanswered_session_loses_its_place_to_the_next(applications: Applications) -> None:
    await applications.comes("viewer 1", answers=True)
    await applications.comes("viewer 2")
    assert applications.sessions.unanswered == 1
    await applications.later(1.9)
    with pytest.raises(TooManySessions):
        await applications.comes("viewer 3")
    await applications.later(0.1)
    await applications.comes("viewer 3")
    await settle()
    assert applications.made["viewer 2"].session.stream_ids == ()
    assert [bye.reason for bye in applications.made["viewer 2"].byes] == [
        "the offer was not answered in time, and another application needs the place"
    ]
    assert (len(applications.sessions), applications.sessions.displaced) == (2, 1)
    # The one that has answered stays, however long ago that was.
    await applications.later(5)
    await applications.comes("viewer 4")
    assert applications.made["viewer 1"].session.stream_ids == ("viewer 1",)


async def test_a_session_without_streams_makes_room(sessions: StreamSessions) -> None:
    alice, bob = sessions.open("alice"), sessions.open("bob")
    connect(alice, "a")
    connect(bob, "b")
    assert len(sessions) == 2
    alice.disconnect("a")
    connect(sessions.open("carol"), "c")
    await settle()
    assert set(sessions) == {bob, sessions.open("carol")}
    assert not alice.peer_ids
    with pytest.raises(TooManySessions):
        sessions.open("dave")


async def test_a_component_is_held_for_all_and_for_those_to_come(sessions: StreamSessions) -> None:
    alice = sessions.open("alice")
    connect(alice, "a")
    sessions.hold("engine/Video")
    bob = sessions.open("bob")
    connect(bob, "b")
    connect(bob, "c")
    bob.suspend("c")
    held = [stream.suspended_by for session in (alice, bob) for stream in session._streams]
    assert held == [{Party.ENGINE}, {Party.ENGINE}, {Party.ENGINE, Party.APPLICATION}]
    sessions.release("engine/Video")
    connect(alice, "d")
    held = [stream.suspended_by for session in (alice, bob) for stream in session._streams]
    assert held == [set(), set(), set(), {Party.APPLICATION}]


async def test_a_client_that_goes_takes_its_streams_along(sessions: StreamSessions) -> None:
    alice = sessions.open("alice")
    connect(alice, "a")
    await sessions.close("alice", "gone")
    assert alice.stream_ids == ()
    with pytest.raises(UnknownStream):
        sessions.with_stream("alice", "a")


async def test_a_session_that_fails_to_end_does_not_keep_the_others(
    sessions: StreamSessions, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    alice, bob = sessions.open("alice"), sessions.open("bob")
    connect(bob, "b")
    await settle()

    async def fail(reason: str) -> None:
        raise RuntimeError(reason)

    monkeypatch.setattr(alice, "close", fail)
    with caplog.at_level(logging.ERROR):
        await sessions.aclose("the engine stops")
    assert bob.stream_ids == ()
    assert "a session did not end cleanly" in caplog.text


async def test_an_unknown_aiortc_is_refused_before_anybody_is_served(monkeypatch: pytest.MonkeyPatch) -> None:
    async def fail() -> None:
        raise UnsupportedLibrary("aiortc 9")

    monkeypatch.setattr(sessions_module, "self_test", fail)
    with pytest.raises(UnsupportedLibrary):
        async with StreamSessions(lambda client_id: Application().session):
            pytest.fail("served")
