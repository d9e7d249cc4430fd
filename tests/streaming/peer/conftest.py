"""The owner of one peer connection without a network."""

from collections.abc import AsyncIterator

import pytest

from tests.support.peer_owner import Owner
from tests.support.viewing import WirelessConnection


@pytest.fixture
async def owner(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Owner]:
    WirelessConnection.stand_in(monkeypatch)
    owner = Owner()
    yield owner
    owner.peer.end_connection("the test is over")
    await owner.peer.closed()
    await owner.tasks.aclose()
    assert owner.failures == []
    assert owner.connection.closed
    assert owner.ended == ["engine/p"]
    assert all(rendition.readers == 0 for rendition in owner.publisher.made.values())
