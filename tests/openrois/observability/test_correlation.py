"""Every task knows for which connection and request it works."""

import asyncio

from openrois.observability import correlation


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


def test_of_a_long_id_no_more_is_kept_than_is_shown() -> None:
    """It is chosen by the other side, and what a request starts may go on for days."""
    for request_id, kept in (("x" * 60_000, "x" * 40), (7, 7), (None, None)):
        correlation.serve(request_id)
        assert correlation.request.get() == kept
