"""What gateways tell each other of subjects: enough that a quota holds for all of them, and not much."""

import json
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from openrois.auth.subject_quotas import SubjectQuotas, Usage
from openrois.errors import OutOfResources
from openrois.federation import shared_quotas
from openrois.federation.shared_quotas import TOLD, TOLD_AT_ONCE, SharedQuotas
from tests.support.newer import with_more
from tests.support.quotas import Session


class Here:
    """A gateway with what subjects have there."""

    def __init__(self, gateway_id: str, **most: int) -> None:
        self.gateway_id = gateway_id
        self.quotas = SubjectQuotas(**most)
        self.shared = SharedQuotas(gateway_id, self.quotas)
        self.stack = ExitStack()
        self.told: list[Mapping[str, Usage]] = []
        self.taken: dict[str, list[ExitStack]] = {}
        self.speaking: list[ExitStack] = []

    def speaks_to(self, other: "Here") -> ExitStack:
        """Tell another gateway from now on; what is returned ends that."""
        stack = ExitStack()
        hear = stack.enter_context(other.shared.hearing())

        def notify(method: str, params: Mapping[str, Any]) -> None:
            assert method == TOLD
            self.told.append(params["used"])
            hear(json.loads(json.dumps(params)))

        stack.enter_context(self.shared.telling(notify))
        self.speaking.append(stack)
        return stack

    def connect(self, name: str, count: int = 1) -> None:
        """Connect applications of a subject, or raise."""
        for _ in range(count):
            stack = ExitStack()
            stack.enter_context(self.quotas.connected(name))
            self.taken.setdefault(name, []).append(stack)

    def disconnect(self, name: str, count: int = 1) -> None:
        for _ in range(count):
            self.taken[name].pop().close()

    def stream(self, name: str, count: int) -> Session:
        """Let a session have streams."""
        session = Session(name, [str(number) for number in range(count)])
        self.stack.enter_context(self.quotas.serving(session))
        self.quotas.note_streams(session)
        return session


def cluster(ids: str, **most: int) -> dict[str, Here]:
    """Return gateways that all speak to each other."""
    gateways = {each: Here(each, **most) for each in ids}
    for near in gateways.values():
        for far in gateways.values():
            if near is not far:
                near.speaks_to(far)
    return gateways


def settle(gateways: Mapping[str, Here], times: int = 2) -> None:
    """Let so many tellings pass; two of them are what a quota needs."""
    for _ in range(times):
        for each in gateways.values():
            each.shared.tell_changes(len(gateways))


def test_a_subject_with_all_it_may_have_at_one_gateway_has_nothing_more_at_another() -> None:
    both = cluster("ab", connections=4, sessions=8)
    a, b = both.values()
    a.connect("ann", 4)
    settle(both, 1)
    with pytest.raises(OutOfResources, match="at most 4 connections; at other gateways there are 4"):
        b.connect("ann")
    b.connect("bob")
    a.disconnect("ann")
    settle(both, 1)
    b.connect("ann")


def test_each_gateway_knows_a_few_of_a_subject_where_one_has_many() -> None:
    three = cluster("abc", connections=9, sessions=18)
    three["a"].connect("ann", 7)
    three["b"].connect("ann")
    three["c"].connect("ann")
    settle(three)
    for each in three.values():
        with pytest.raises(OutOfResources):
            each.connect("ann")
    # It is told of no more when no gateway has its share.
    three["a"].disconnect("ann", 5)
    settle(three)
    for each in three.values():
        assert each.shared._told == {}
        assert each.quotas.elsewhere("ann") == Usage()


def test_sessions_that_may_be_resumed_count_where_their_application_was() -> None:
    both = cluster("ab", connections=4, sessions=4)
    a, b = both.values()
    absent = [Session("ann"), Session("ann"), Session("ann")]
    a.quotas.absent = lambda: absent
    b.quotas.absent = lambda: [Session("ann", is_relayed=True)] * 3
    settle(both, 1)
    b.connect("ann")
    settle(both)
    with pytest.raises(OutOfResources, match="at most 4 sessions; at other gateways there are 3"):
        b.connect("ann")
    absent.clear()
    settle(both, 1)
    b.connect("ann")


def test_a_stream_counts_once_at_the_gateway_that_has_its_engine() -> None:
    both = cluster("ab", streams=3)
    a, b = both.values()
    at_owner = a.stream("ann", 2)
    settle(both)
    front = b.stream("ann", 0)
    b.quotas.require_stream(front)
    at_owner.streams.append("one more")
    a.quotas.note_streams(at_owner)
    settle(both, 1)
    with pytest.raises(OutOfResources, match="at most 3 streams; at other gateways there are 3"):
        b.quotas.require_stream(front)
    with pytest.raises(OutOfResources, match=r"at most 3 streams$"):
        a.quotas.require_stream(at_owner)


def test_what_a_gateway_told_is_forgotten_with_its_connection() -> None:
    a, b = Here("a", connections=2, sessions=4), Here("b", connections=2, sessions=4)
    speaking = a.speaks_to(b)
    a.connect("ann", 2)
    settle({"a": a, "b": b})
    with pytest.raises(OutOfResources):
        b.connect("ann")
    speaking.close()
    b.connect("ann", 2)


def test_a_gateway_that_dials_anew_begins_anew() -> None:
    a, b = Here("a", connections=2, sessions=4), Here("b", connections=2, sessions=4)
    former = a.speaks_to(b)
    a.connect("ann", 2)
    settle({"a": a, "b": b})
    # The former connection is half open, and ends later; what there is is told at the beginning of the next one.
    latter = a.speaks_to(b)
    assert b.quotas.elsewhere("ann") == Usage(2, 2, 0)
    former.close()
    assert b.quotas.elsewhere("ann") == Usage(2, 2, 0)
    latter.close()
    assert b.quotas.elsewhere("ann") == Usage()


def test_of_many_subjects_with_little_nothing_is_told() -> None:
    both = cluster("ab", connections=4, sessions=8)
    for number in range(2000):
        both["a"].connect(f"subject {number}")
    settle(both)
    assert both["a"].told == []


def test_what_changed_of_many_subjects_is_told_a_page_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    both = cluster("ab", connections=1, sessions=2)
    a, b = both.values()
    for number in range(TOLD_AT_ONCE + 1):
        a.connect(f"subject {number}")
    settle(both, 1)
    assert list(map(len, a.told)) == [TOLD_AT_ONCE]
    settle(both, 1)
    assert list(map(len, a.told)) == [TOLD_AT_ONCE, 1]
    # One that comes later gets all of them, in pages as well.
    c = Here("c", connections=1, sessions=2)
    a.told.clear()
    a.speaks_to(c)
    assert list(map(len, a.told)) == [TOLD_AT_ONCE, 1]
    assert c.quotas.elsewhere(f"subject {TOLD_AT_ONCE}") == b.quotas.elsewhere(f"subject {TOLD_AT_ONCE}") != Usage()
    # All are looked at when a gateway comes; nothing has changed of them.
    a.told.clear()
    a.shared.tell_changes(3)
    assert a.told == []


def test_subjects_beyond_those_that_are_told_of_count_at_their_gateway_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shared_quotas, "MOST_TOLD", 2)
    both = cluster("ab", connections=1, sessions=2)
    a, b = both.values()
    for name in ("ann", "bob", "eve"):
        a.connect(name)
    settle(both)
    assert [b.quotas.elsewhere(name).connections for name in ("ann", "bob", "eve")] == [1, 1, 0]
    b.connect("eve")
    # A gateway takes no more of another one, either.
    with b.shared.hearing() as hear:
        hear({"gateway": "z", "used": {str(number): [1, 1, 0] for number in range(5)}})
        assert sum(b.quotas.elsewhere(str(number)).connections for number in range(5)) == 2


def test_what_does_not_fit_is_no_telling() -> None:
    here = Here("a")
    with here.shared.hearing() as hear:
        for used in ({"ann": [1, 1]}, {"ann": [1, 1, -1]}, {str(number): [1, 1, 1] for number in range(1025)}):
            with pytest.raises(ValidationError):
                hear({"gateway": "b", "used": used})
    assert here.quotas.elsewhere("ann") == Usage()


def test_what_a_newer_gateway_says_besides_is_passed_over() -> None:
    here = Here("a")
    with here.shared.hearing() as hear:
        hear(with_more({"gateway": "b", "used": {"ann": [1, 2, 3]}}))
        assert here.quotas.elsewhere("ann") == Usage(1, 2, 3)


STEPS = st.lists(st.tuples(st.sampled_from("abc"), st.booleans(), st.integers(1, 5)), max_size=30)


@given(STEPS, st.integers(1, 12))
def test_no_subject_has_more_than_it_may_have_when_gateways_have_told(
    steps: list[tuple[str, bool, int]], most: int
) -> None:
    three = cluster("abc", connections=most, sessions=2 * most)
    for gateway_id, comes, count in steps:
        here = three[gateway_id]
        for _ in range(count):
            if not comes:
                if here.taken.get("ann"):
                    here.disconnect("ann")
            else:
                had = sum(len(each.taken.get("ann", ())) for each in three.values())
                try:
                    here.connect("ann")
                except OutOfResources:
                    assert had == most
                else:
                    assert had < most
            settle(three)
