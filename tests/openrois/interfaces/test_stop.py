"""Who may stop everything on an engine, and requests for a component that a new token takes out of scope."""

from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.token_expiry import TokenExpiry
from openrois.session.session import EngineHost
from tests.support.authorization import Place, principal
from tests.support.components import Bell, Lamp

LAMP = {"component_ref": "robot/lamp"}


@pytest.mark.parametrize("params", [{"engine_id": "robot"}, LAMP])
async def test_every_operator_who_sees_a_part_of_what_acts_may_stop_all(params: dict[str, Any]) -> None:
    engine = Engine("gateway")
    await engine.attach(LocalRegistry("robot", (Lamp(), Bell())))
    async with TaskScope() as tasks:
        here = Place(EngineHost(engine, tasks), {})
        for role in ("operator", "administrator"):
            async with here.application(principal(role, "robot/lamp")) as app:
                assert (await app.result("openrois.stop_all", params))["stopped"] == ["robot/lamp"]
            # What is out of scope is refused as what does not exist.
            for scope in ("robot/bell", "rover/*"):
                async with here.application(principal(role, scope)) as app:
                    assert await app.code("openrois.stop_all", params) == "UNSUPPORTED"
        for role in ("viewer", "maintenance"):
            async with here.application(principal(role, "*")) as app:
                assert await app.code("openrois.stop_all", params) == "UNSUPPORTED"


async def test_without_params_it_is_what_the_application_controls() -> None:
    engine = Engine("gateway")
    await engine.attach(LocalRegistry("robot", (Lamp(),)))
    await engine.attach(LocalRegistry("rover", (Lamp(),)))
    async with TaskScope() as tasks:
        here = Place(EngineHost(engine, tasks), {})
        async with here.application(principal("operator", "*")) as app:
            assert (await app.result("openrois.stop_all", {}))["stopped"] == []
            assert await app.code("rois.command.bind", {"component_ref": "rover/lamp"}) == "OK"
            assert (await app.result("openrois.stop_all", {}))["stopped"] == ["rover/lamp"]
        async with here.application(principal("administrator", "*")) as app:
            assert sorted((await app.result("openrois.stop_all", {}))["stopped"]) == ["robot/lamp", "rover/lamp"]


async def test_a_component_that_left_the_scope_is_not_waited_for() -> None:
    engine, expiry = Engine("gateway"), TokenExpiry(principal("operator", "*", subject="bob"))
    await engine.attach(LocalRegistry("robot", (Lamp(),)))
    async with TaskScope() as tasks:
        here = Place(EngineHost(engine, tasks), {})
        async with here.application(principal("operator", "*")) as ann, here.application(expiry) as bob:
            assert await ann.code("rois.command.bind", LAMP) == "OK"
            assert await bob.code("openrois.lease.request", LAMP) == "OK"
            expiry.replace(principal("viewer", "*", subject="bob"))
            assert here.host.leases.model.waiting.count() == 0
            assert await ann.code("rois.command.release", LAMP) == "OK"
            assert here.host.leases.model.holding.held() == frozenset()
