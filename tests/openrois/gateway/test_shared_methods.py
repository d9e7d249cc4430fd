"""Sessions share the tables of their methods, of a cluster or not: what differs is whose they are."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType, SimpleNamespace
from typing import Any, cast

import pytest

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal, Role
from openrois.engine.engine import Engine
from openrois.federation.federation import Federation
from openrois.gateway.applications import _Served
from openrois.gateway.token_expiry import TokenExpiry
from openrois.interfaces.enforcement import enforced
from openrois.jsonrpc.method_tables import BoundMethods
from openrois.session.session import EngineHost
from openrois.transport.memory import memory_pair


def federation(engine: Engine) -> Federation:
    parts = {
        "link": SimpleNamespace(gateway_id="a", trouble="", present={}),
        "directorate": SimpleNamespace(owners=MappingProxyType({})),
        **dict.fromkeys(("lines", "resume_store", "other_way", "quotas")),
    }
    return Federation(engine=engine, **cast(Any, parts))


@pytest.fixture(params=["alone", "of a cluster"])
async def two(request: pytest.FixtureRequest) -> tuple[_Served, _Served]:
    """Return the sessions of an operator and of a viewer."""
    host = EngineHost(Engine("gateway"), TaskScope())
    others = federation(host.engine) if request.param == "of a cluster" else None

    def served(name: str, role: Role) -> _Served:
        return _Served(host, memory_pair()[0], TokenExpiry(Principal(name, frozenset({role}), ("*",))), others)

    return served("ann", Role.OPERATOR), served("ben", Role.VIEWER)


def tables(methods: object) -> Iterator[Mapping[str, Any]]:
    """Yield the tables that methods are made of."""
    if isinstance(methods, BoundMethods):
        yield from (table for table, _ in methods._parts)
    else:
        yield from (*tables(cast(Any, methods)._routed), *tables(cast(Any, methods)._others))


def test_sessions_have_the_same_tables(two: tuple[_Served, _Served]) -> None:
    first, second = ([id(table) for table in tables(each.methods)] for each in two)
    assert first == second
    assert list(two[0].methods) == list(two[1].methods)
    assert len(two[0].methods) == len(set(two[0].methods)) > 30


async def test_a_method_is_called_for_its_own_session(two: tuple[_Served, _Served]) -> None:
    ann, ben = two
    await ben.methods["rois.system.connect"]({})
    assert (ann.app.connected, ben.app.connected) == (False, True)
    await ann.methods["openrois.hello"]({"version": "1", "extensions": ["openrois.lease"]})
    assert (ann.app.leasing, ben.app.leasing) == (True, False)


async def test_a_session_with_other_rights_has_not_what_another_may_call(two: tuple[_Served, _Served]) -> None:
    reasons = [
        (await enforced(each.app, each.methods)["rois.command.bind"]({"component_ref": "gateway/arm"})).reason
        for each in two
    ]
    assert "gateway/arm" in reasons[0]
    assert reasons[1] == "rois.command.bind is not for the roles of this application"


def test_what_no_table_has_is_missing(two: tuple[_Served, _Served]) -> None:
    assert "rois.command.fly" not in two[0].methods
    assert two[0].methods.get("rois.command.fly") is None
