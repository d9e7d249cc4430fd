"""Notification of changes: a few as they come, of a flood no more than the limit, and always the last."""

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest

from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.session import change_notice
from openrois.session.change_notice import CHANGES_AT_ONCE, ChangeNotice
from openrois.types.directory import MAX_CHANGED
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
        self.messages: list[tuple[str, Mapping[str, Any]]] = []
        self.there: set[str] = set()
        self.notice = ChangeNotice(self._notify, self.there.__contains__, self.clock)

    def _notify(self, method: str, params: Mapping[str, Any]) -> None:
        self.messages.append((method, params))
        self.times.put_nowait(self.clock.now)

    def burst(self) -> list[float]:
        """Change very often; return the times of the notifications."""
        for _ in range(1000):
            self.notice.changed(("robot",))
        return [self.times.get_nowait() for _ in range(self.times.qsize())]


async def test_a_flood_is_cut_and_its_last_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Told(monkeypatch)
    assert told.burst() == [0.0] * CHANGES_AT_ONCE
    told.clock.now = 0.001
    assert await asyncio.wait_for(told.times.get(), 60) == 0.001
    told.clock.now = 60.0
    assert told.burst() == [60.0] * CHANGES_AT_ONCE


async def test_the_base_wire_learns_that_something_changed_and_the_extension_of_which_engines(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = Told(monkeypatch)
    told.there.update({"a", "b"})
    told.notice.changed(("a",))
    told.notice.name_engines()
    told.notice.changed(("b", "c", "a"))
    assert told.messages == [
        (CHANGED, {}),
        ("openrois.directory.changed", {"changed": ["a", "b"], "gone": ["c"], "unnamed": 0}),
    ]


async def test_what_changes_while_a_notification_waits_is_named_as_it_is_then(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Told(monkeypatch)
    told.notice.name_engines()
    told.burst()
    told.there.add("comes")
    told.notice.changed(("comes", "goes"))
    told.there.add("goes")
    told.there.remove("comes")
    told.clock.now = 0.001
    await asyncio.wait_for(told.times.get(), 60)
    expected = {"changed": ["goes"], "gone": ["comes", "robot"], "unnamed": 0}
    assert told.messages[-1] == ("openrois.directory.changed", expected)


async def test_more_engines_than_a_notification_names_are_listed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Told(monkeypatch)
    told.notice.name_engines()
    told.notice.changed(f"engine-{number:03}" for number in range(MAX_CHANGED + 1))
    ((_, params),) = told.messages
    assert (len(params["gone"]), params["unnamed"]) == (MAX_CHANGED, 1)
    told.notice.changed(("engine-000",))
    assert told.messages[-1][1] == {"changed": [], "gone": ["engine-000"], "unnamed": 0}


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
