"""Views that follow an engine show what its whole directory would show."""

import asyncio
from typing import cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.auth.principal import Principal, Role, engines_named
from openrois.contract import ComponentBus, Directory
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.scope.filter import scoped_directory
from openrois.scope.views import ViewChange, Views
from tests.support.components import Bell, Lamp
from tests.support.offers import Bus, offer
from tests.support.offers import engine as described


def viewer(*scope: str, role: Role = Role.VIEWER) -> Principal:
    return Principal("anna", frozenset({role}), scope)


@pytest.mark.parametrize(
    ("scope", "named"),
    [
        ([], set()),
        (["robot/*", "robot/arm", "other/[ab]"], {"robot", "other"}),
        (["robot"], set()),
        (["robot/*", "*/eye"], None),
        (["r?bot/arm"], None),
        (["[r]obot/arm"], None),
        (["*"], None),
        (["rob*"], None),
    ],
)
def test_the_engines_that_a_scope_names(scope: list[str], named: set[str] | None) -> None:
    assert engines_named(scope) == named


async def test_those_of_one_scope_share_a_view_for_as_long_as_one_follows_it() -> None:
    views = Views(Engine("gateway"))
    first, second = views.enter(viewer("robot/*")), views.enter(viewer("robot/*", role=Role.ADMINISTRATOR))
    assert first is second
    assert views.enter(viewer("robot/eye")) is not first
    views.leave(first)
    assert views.enter(viewer("robot/*")) is first
    views.leave(first)
    views.leave(first)
    assert views.enter(viewer("robot/*")) is not first


async def test_where_everything_is_seen_nothing_is_copied() -> None:
    engine = Engine("gateway")
    view = Views(engine).enter(viewer("other/*", "*"))
    assert view.tree is engine.tree


async def test_a_view_hears_of_what_can_be_seen_and_of_nothing_else() -> None:
    engine = Engine("gateway")
    views = Views(engine)
    heard: dict[str, list[ViewChange]] = {}
    for scope in ("robot/lamp", "*/lamp", "other/*"):
        views.enter(viewer(scope)).changes.add(heard.setdefault(scope, []).append)
    robot = LocalRegistry("robot", [Lamp(), Bell()])
    await engine.attach(robot)
    await engine.refresh(robot)
    engine.detach(robot)
    robots = frozenset({"robot"})
    came, same = ViewChange(True, robots), ViewChange(False, robots)
    gone = ViewChange(True, robots, frozenset({"robot/lamp"}))
    assert heard == {"robot/lamp": [came, same, gone], "*/lamp": [came, same, gone], "other/*": []}


async def test_a_view_names_those_engines_of_a_bus_that_have_changed() -> None:
    engine = Engine("gateway")
    bodies = [described("a", "lamp"), described("b", "lamp"), described("c", "lamp")]
    bus = Bus(offer(described("inner", below=tuple(bodies))))
    await engine.attach(cast(ComponentBus, bus))
    heard: list[ViewChange] = []
    Views(engine).enter(viewer("*/lamp")).changes.add(heard.append)
    former = engine.tree.offer_of(cast(ComponentBus, bus))
    assert former is not None
    kept = former.profile.sub_profiles[:2]
    bus.offered = offer(described("inner", below=(*kept, described("c", "lamp", "bell"), described("d", "lamp"))))
    await engine.refresh(cast(ComponentBus, bus))
    assert heard == [ViewChange(True, frozenset({"inner", "c", "d"}))]


SCOPES = [(), ("*",), ("a/*",), ("a/lamp", "b/bell"), ("*/lamp",), ("c/x",), ("b",), ("a/*", "?/bell")]


class Offering:
    """A bus that only offers."""

    def __init__(self, engine_id: str, has_bell: bool) -> None:
        self.registry = LocalRegistry(engine_id, [Lamp(), *([Bell()] if has_bell else [])])

    def __getattr__(self, name: str) -> object:
        return getattr(self.registry, name)


@given(st.lists(st.tuples(st.sampled_from("abc"), st.sampled_from(["attach", "refresh", "detach"]), st.booleans())))
def test_views_entered_at_any_time_show_the_same(steps: list[tuple[str, str, bool]]) -> None:
    asyncio.run(follow(steps))


async def follow(steps: list[tuple[str, str, bool]]) -> None:
    engine = Engine("gateway")
    early = Views(engine)
    followed = {scope: early.enter(viewer(*scope)) for scope in SCOPES}
    buses: dict[str, ComponentBus] = {}
    for engine_id, step, has_bell in steps:
        if step == "attach" and engine_id not in buses:
            buses[engine_id] = Offering(engine_id, has_bell)  # type: ignore[assignment]
            await engine.attach(buses[engine_id])
        elif step == "refresh" and engine_id in buses:
            buses[engine_id].registry = LocalRegistry(engine_id, [Bell()] if has_bell else [])  # type: ignore[attr-defined]
            await engine.refresh(buses[engine_id])
        elif step == "detach" and engine_id in buses:
            engine.detach(buses.pop(engine_id))
    late = Views(engine)
    for scope, view in followed.items():
        wanted = scoped_directory(engine.directory, viewer(*scope))
        assert same(view.tree.directory, wanted), scope
        assert same(late.enter(viewer(*scope)).tree.directory, wanted), scope


def same(one: Directory, other: Directory) -> bool:
    """Tell whether two directories differ at most in their order: that of a view is the one in which things appear."""
    below = [sorted(each.profile.sub_profiles, key=lambda profile: profile.identifier.code) for each in (one, other)]
    refs = [sorted(each.profile.component_ids) for each in (one, other)]
    return (below[0], refs[0], one.component_profiles) == (below[1], refs[1], other.component_profiles)
