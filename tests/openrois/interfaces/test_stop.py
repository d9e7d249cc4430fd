"""Who may stop everything on an engine, and what is left of waiting for a component when a new token shows less."""

from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.token_expiry import TokenExpiry
from openrois.session.session import EngineHost
from tests.support.authorization import Place, principal
from tests.support.components import Lamp

LAMP = {"component_ref": "robot/lamp"}


@pytest.mark.parametrize("params", [{"engine_id": "robot"}, LAMP])
async def test_who_holds_nothing_of_an_engine_does_not_stop_it(params: dict[str, Any]) -> None:
    engine = Engine("gateway")
    await engine.attach(LocalRegistry("robot", (Lamp(),)))
    await engine.attach(LocalRegistry("rover", (Lamp(),)))
    async with TaskScope() as tasks:
        here = Place(EngineHost(engine, tasks), {})
        async with here.application(principal("operator", "*")) as app:
            assert await app.code("rois.command.bind", {"component_ref": "rover/lamp"}) == "OK"
            assert await app.code("openrois.stop_all", params) == "OUT_OF_RESOURCES"
            assert (await app.result("openrois.stop_all", {}))["stopped"] == ["rover/lamp"]
            assert await app.code("rois.command.bind", LAMP) == "OK"
            assert (await app.result("openrois.stop_all", params))["stopped"] == ["robot/lamp"]
        async with here.application(principal("administrator", "*")) as app:
            assert (await app.result("openrois.stop_all", params))["stopped"] == ["robot/lamp"]


async def test_who_is_shown_a_component_no_more_does_not_wait_for_it() -> None:
    engine, tenure = Engine("gateway"), TokenExpiry(principal("operator", "*", subject="bob"))
    await engine.attach(LocalRegistry("robot", (Lamp(),)))
    async with TaskScope() as tasks:
        here = Place(EngineHost(engine, tasks), {})
        async with here.application(principal("operator", "*")) as ann, here.application(tenure) as bob:
            assert await ann.code("rois.command.bind", LAMP) == "OK"
            assert await bob.code("openrois.lease.request", LAMP) == "OK"
            tenure.replace(principal("viewer", "*", subject="bob"))
            assert here.host.leases.model.waiting.count() == 0
            assert await ann.code("rois.command.release", LAMP) == "OK"
            assert here.host.leases.model.holding.held() == frozenset()
