"""Notification of changes: a few as they come, of a flood no more than the limit, and always the last."""

import asyncio

import pytest

from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.session import change_notice
from openrois.session.change_notice import CHANGES_AT_ONCE, ChangeNotice
from tests.support.clock import Clock
from tests.support.components import Lamp
from tests.support.wire import application, hosted

CHANGED = "rois.system.profile_changed"


class Told:
    """Counts notifications, on a clock that the test turns; a sleep that is not over yet polls each millisecond."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(change_notice, "CHANGES_PER_SECOND", 1000)
        self.clock = Clock()
        self.times: asyncio.Queue[float] = asyncio.Queue()
        self.notice = ChangeNotice(lambda: self.times.put_nowait(self.clock.now), self.clock)

    def burst(self) -> list[float]:
        """Change very often; return the times of the notifications."""
        for _ in range(1000):
            self.notice.changed()
        return [self.times.get_nowait() for _ in range(self.times.qsize())]


async def test_a_flood_is_cut_and_its_last_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Told(monkeypatch)
    assert told.burst() == [0.0] * CHANGES_AT_ONCE
    told.clock.now = 0.001
    assert await asyncio.wait_for(told.times.get(), 60) == 0.001
    told.clock.now = 60.0
    assert told.burst() == [60.0] * CHANGES_AT_ONCE


async def test_a_departed_application_is_not_notified(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Told(monkeypatch)
    told.notice.close()
    told.burst()
    told.notice.close()
    assert told.notice._due is not None
    assert told.notice._due.cancelled()


async def test_an_engine_that_comes_and_goes_for_ever_does_not_keep_applications_busy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(change_notice, "CHANGES_PER_SECOND", 1 / 60)
    async with hosted(Engine("gateway")) as host, application(host) as app:
        await app.ask("rois.system.connect")
        for _ in range(200):
            registry = LocalRegistry("robot", (Lamp(),))
            await host.engine.attach(registry)
            host.engine.detach(registry)
        await app.ask("rois.system.get_profile", condition="")
        told = [app.told.get_nowait()[0] for _ in range(app.told.qsize())]
        assert told == [CHANGED] * CHANGES_AT_ONCE
