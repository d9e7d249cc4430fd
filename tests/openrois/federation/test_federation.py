"""A gateway's own part in its cluster."""

import asyncio
from types import MappingProxyType, SimpleNamespace
from typing import Any, cast

import pytest

from openrois.engine.engine import Engine
from openrois.errors import EngineUnreachable
from openrois.federation.federation import TOUCH_INTERVAL, Federation
from openrois.ownership.claims import Owner


def federation(**parts: Any) -> Federation:
    link = SimpleNamespace(gateway_id="a", trouble="", present={})
    directorate = SimpleNamespace(owners=MappingProxyType({"robot": Owner("robot", "b", "i", 1)}))
    given = {"link": link, "directorate": directorate, "lines": None, "resume_store": None, "other_way": None}
    return Federation(engine=Engine("gateway"), **cast(Any, {"quotas": None, **given, **parts}))


async def test_sessions_that_live_are_kept_in_the_store() -> None:
    slept, touched = list[float](), list[tuple[str, ...]]()

    async def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) > 2:
            await asyncio.Event().wait()

    async def touch(line_ids: tuple[str, ...]) -> None:
        touched.append(line_ids)

    here = federation(resume_store=SimpleNamespace(touch=touch), sleep=sleep)
    first, second = object(), object()
    here.keep_alive("line", first)
    here.keep_alive("line", second)
    here.forget_line("line", first)
    keeping = asyncio.ensure_future(here._touch_lines())
    for _ in range(10):
        await asyncio.sleep(0)
    keeping.cancel()
    assert slept == [TOUCH_INTERVAL] * 3
    assert touched == [("line",)] * 2
    here.forget_line("line", second)
    assert here._kept == {}


def test_an_engine_of_another_gateway_that_is_not_reached_is_named_with_the_reason() -> None:
    here = federation()
    here.require_reachable("without-owner")
    with pytest.raises(EngineUnreachable, match="robot belongs to gateway b, which is not reached: it is not there"):
        here.require_reachable("robot")
    link = SimpleNamespace(gateway_id="a", trouble="NATS is away", present={})
    with pytest.raises(EngineUnreachable, match="not reached: NATS is away"):
        federation(link=link).require_reachable("robot")
    link = SimpleNamespace(gateway_id="a", trouble="", present={"b": None})
    with pytest.raises(EngineUnreachable, match="not reached: it has not told yet what it offers"):
        federation(link=link).require_reachable("robot")
    assert here.owner_of("robot") == "b"
    assert here.owner_of("other") is None
