"""An application with a media session and its publisher."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from tests.support.theatre import Theatre
from tests.support.viewing import WirelessConnection


@pytest.fixture
async def theatre(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Theatre]:
    WirelessConnection.stand_in(monkeypatch)
    theatre = Theatre()
    async with theatre.session:
        yield theatre
    assert theatre.session.peer_ids == theatre.session.stream_ids == ()
    assert all(connection.closed for connection in theatre.connections)
    assert all(rendition.readers == 0 for rendition in theatre.publisher.made.values())
    ended = [change.stream_id for change in theatre.changes if change.ended]
    assert sorted(ended) == sorted(set(ended))
    others = asyncio.all_tasks() - {asyncio.current_task()}
    assert [task.get_name() for task in others if "session" in task.get_name()] == []
