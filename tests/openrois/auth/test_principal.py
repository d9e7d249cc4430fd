"""Roles, methods and scopes: one table, and nothing beside it."""

import fnmatch

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_signaling.methods import signaling_methods
from openrois_signaling.relay import Relay

from openrois.auth.principal import ALLOWED, LOCAL, Principal, Role
from openrois.types.methods import METHODS

BASE = [method.name for method in METHODS if not method.extension]
STREAMS = [method.name for method in METHODS if method.extension == "rois.stream"]
SIGNALING = sorted(signaling_methods(Relay(None, lambda: 0.0), "anna", None))  # type: ignore[arg-type]
ACTING = {f"rois.command.{verb}" for verb in ("bind", "bind_any", "release", "set_parameter", "execute")}


def principal(*roles: Role, scope: tuple[str, ...] = ("*",)) -> Principal:
    return Principal("anna", frozenset(roles), scope)


def test_every_method_of_the_gateway_stands_in_the_table() -> None:
    assert len(BASE) == 16
    assert set(BASE) | set(STREAMS) | set(SIGNALING) <= ALLOWED.keys()
    assert {method.name for method in METHODS} <= ALLOWED.keys()


@pytest.mark.parametrize(
    ("role", "may"),
    [
        (Role.VIEWER, {*BASE, *STREAMS, *SIGNALING} - ACTING),
        (Role.VISITOR, {*BASE, *STREAMS, *SIGNALING} - ACTING),
        (Role.LISTENER, {*BASE, *STREAMS, *SIGNALING} - ACTING),
        (Role.MAINTENANCE, set(BASE) - ACTING),
        (Role.OPERATOR, {*BASE, *STREAMS, *SIGNALING}),
        (Role.ADMINISTRATOR, {*BASE, *STREAMS, *SIGNALING}),
        (Role.ADAPTER, set()),
    ],
)
def test_what_each_role_may(role: Role, may: set[str]) -> None:
    table = {*BASE, *STREAMS, *SIGNALING}
    assert {method for method in table if principal(role).may_call(method)} == may


def test_an_administrator_may_all_that_there_is() -> None:
    assert all(Role.ADMINISTRATOR in roles for roles in ALLOWED.values())
    assert all(Role.ADAPTER not in roles for roles in ALLOWED.values())


@pytest.mark.parametrize(
    "method", ["", "rois", "rois.command", "rois.command.bind ", "ROIS.command.bind", "__class__", "openrois.unknown"]
)
@pytest.mark.parametrize("role", list(Role))
def test_an_unknown_method_is_denied(role: Role, method: str) -> None:
    assert not principal(role).may_call(method)
    assert not LOCAL.may_call(method)


@given(st.text())
def test_only_the_table_allows(method: str) -> None:
    assert principal(*Role).may_call(method) == (method in ALLOWED)


def test_roles_add_up() -> None:
    both = principal(Role.MAINTENANCE, Role.VIEWER)
    assert both.may_call("rois.stream.connect_stream")
    assert not both.may_call("rois.command.bind")
    assert not principal().may_call("rois.system.connect")


def test_paths() -> None:
    assert [role for role in Role if principal(role).is_application] == [
        Role.VIEWER,
        Role.VISITOR,
        Role.LISTENER,
        Role.MAINTENANCE,
        Role.OPERATOR,
        Role.ADMINISTRATOR,
    ]
    assert [role for role in Role if principal(role).is_adapter] == [Role.ADMINISTRATOR, Role.ADAPTER]
    assert [role for role in Role if principal(role).is_administrator] == [Role.ADMINISTRATOR]
    assert [role for role in Role if principal(role).is_visitor] == [Role.VISITOR]
    assert [role for role in Role if principal(role).is_listener] == [Role.LISTENER]


@pytest.mark.parametrize(
    ("scope", "seen", "hidden"),
    [
        ((), [], ["", "avatar/Speech"]),
        (("*",), ["avatar/Speech", "a", "", "a\nb"], []),
        (("avatar/*",), ["avatar/Speech", "avatar/a/b", "avatar/"], ["avatar", "avatar2/Speech", "Avatar/Speech"]),
        (("avatar/Speech", "robot_?/*"), ["avatar/Speech", "robot_1/move"], ["avatar/Speech2", "robot_12/move"]),
        (("a|b/x",), ["a|b/x"], ["a", "b/x"]),
        (("[ab]/x",), ["a/x", "b/x"], ["[ab]/x"]),
        ((".*/x",), [".y/x"], ["a/x"]),
        (("[/x",), ["[/x"], ["/x"]),
        (("a/x",), ["a/x"], ["a/x\n", " a/x"]),
    ],
)
def test_scope(scope: tuple[str, ...], seen: list[str], hidden: list[str]) -> None:
    viewer = principal(Role.VIEWER, scope=scope)
    assert [ref for ref in seen if not viewer.sees(ref)] == []
    assert [ref for ref in hidden if viewer.sees(ref)] == []


@given(st.lists(st.text(alphabet="ab/*?[]!-.|\\", max_size=6), max_size=4), st.text(alphabet="ab/.|\\[]", max_size=6))
def test_a_scope_is_its_patterns_one_by_one(scope: list[str], ref: str) -> None:
    assert principal(scope=tuple(scope)).sees(ref) == any(fnmatch.fnmatchcase(ref, pattern) for pattern in scope)


def test_a_principal_is_a_value() -> None:
    assert principal(Role.VIEWER) == principal(Role.VIEWER)
    assert hash(principal(Role.VIEWER)) == hash(principal(Role.VIEWER))
    assert principal(Role.VIEWER) != principal(Role.OPERATOR)


def test_this_machine_may_all() -> None:
    assert all(LOCAL.may_call(method) for method in ALLOWED)
    assert LOCAL.sees("anything/at all")
    assert LOCAL.is_application
    assert LOCAL.is_adapter
    assert LOCAL.expires is None
