"""Every task knows for which connection and request it works."""

import asyncio

from openrois import correlation


async def test_tasks_work_for_what_started_them() -> None:
    async def work() -> str:
        await asyncio.sleep(0)
        return correlation.correlation()

    assert correlation.correlation() == ""
    with correlation.connection("abc"):
        early = asyncio.create_task(work())
        correlation.request.set("x" * 100)
        late = asyncio.create_task(work())
    assert await asyncio.gather(early, late) == ["abc", "abc/" + "x" * 40]
    correlation.request.set(None)
    assert correlation.correlation() == ""
