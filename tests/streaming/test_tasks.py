import asyncio
import logging

import pytest
from openrois_streaming import tasks
from openrois_streaming.tasks import OwnedTasks


async def test_the_owner_hears_of_a_failure_and_of_nothing_else() -> None:
    failures: list[BaseException] = []
    owned = OwnedTasks("test", failures.append)

    async def fail() -> None:
        raise OSError("broken")

    async def succeed() -> int:
        return 5

    good, bad = owned.start(succeed(), "good"), owned.start(fail(), "bad")
    await asyncio.wait({good, bad})
    await asyncio.sleep(0)
    assert await good == 5
    assert [str(failure) for failure in failures] == ["broken"]
    assert bad.get_name() == "test bad"


async def test_nothing_runs_after_it_is_closed() -> None:
    failures: list[BaseException] = []
    owned = OwnedTasks("test", failures.append)
    running = [owned.start(asyncio.Event().wait(), "wait") for _ in range(3)]
    await asyncio.sleep(0)
    await owned.aclose()
    assert all(task.cancelled() for task in running)
    assert failures == []
    await owned.aclose()


async def test_a_task_may_close_its_own_owner() -> None:
    owned = OwnedTasks("test", lambda error: pytest.fail(str(error)))
    other = owned.start(asyncio.Event().wait(), "other")

    async def close() -> str:
        await owned.aclose()
        return "done"

    assert await owned.start(close(), "closer") == "done"
    assert other.cancelled()


async def test_a_task_that_does_not_end_is_named(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(tasks, "CLOSE_TIMEOUT", 0.01)
    owned = OwnedTasks("test", lambda error: pytest.fail(str(error)))
    release = asyncio.Event()

    async def stubborn() -> None:
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            await release.wait()

    task = owned.start(stubborn(), "stubborn")
    await asyncio.sleep(0)
    with caplog.at_level(logging.ERROR):
        await owned.aclose()
    assert caplog.messages == ["test stubborn does not end"]
    release.set()
    await task
