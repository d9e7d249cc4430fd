"""Which gateways are there, by a clock that is turned by hand."""

import pytest

from openrois.cluster import presence as module
from openrois.cluster.frames import Beat
from openrois.cluster.presence import SILENCE, Presence
from tests.support.clock import Clock

pytestmark = pytest.mark.extra(name="cluster")


def beat(gateway: str, link: int = 1, instance: int = 1, **more: object) -> Beat:
    return Beat.model_validate(
        {"gateway": gateway, "instance": f"{instance:016x}", "link": f"{link:016x}", "version": "1", **more}
    )


@pytest.fixture
def clock() -> Clock:
    return Clock(100.0)


@pytest.fixture
def presence(clock: Clock) -> Presence:
    return Presence(clock)


def test_a_gateway_is_there_from_its_first_sign_of_life(presence: Presence) -> None:
    assert not presence.handle_beat(beat("a", attributes={"room": 7}))
    assert list(presence.present) == ["a"]
    assert (presence.present["a"].version, presence.present["a"].attributes) == ("1", {"room": 7})
    assert f"{1:016x}" in presence


def test_a_gateway_is_gone_after_a_second_of_silence_and_not_before(presence: Presence, clock: Clock) -> None:
    presence.handle_beat(beat("a", 1))
    clock.now += 0.5
    presence.handle_beat(beat("b", 2))
    assert presence.next_expiry == 101.0
    clock.now = 100.99
    assert not presence.expire()
    clock.now = 101.0
    assert presence.expire()
    assert list(presence.present) == ["b"]
    assert presence.next_expiry == 101.5
    clock.now = 101.5
    assert presence.expire()
    assert presence.present == {}
    assert presence.next_expiry == 101.5 + SILENCE


def test_nothing_changes_while_it_beats(presence: Presence, clock: Clock) -> None:
    presence.handle_beat(beat("a"))
    before = presence.present
    for _ in range(10):
        clock.now += 0.25
        assert not presence.handle_beat(beat("a"))
        assert not presence.expire()
    assert presence.present is before


def test_what_a_gateway_tells_changes_with_its_next_sign(presence: Presence) -> None:
    presence.handle_beat(beat("a"))
    presence.handle_beat(beat("a", attributes={"drains": True}))
    assert presence.present["a"].attributes == {"drains": True}


def test_a_gateway_that_says_so_is_gone_at_once(presence: Presence) -> None:
    presence.handle_beat(beat("a"))
    assert presence.handle_beat(beat("a", leaving=True))
    assert presence.present == {}
    assert not presence.handle_beat(beat("b", 9, leaving=True))


def test_the_former_connection_of_a_process_is_gone_when_it_has_another(presence: Presence) -> None:
    presence.handle_beat(beat("a", 1))
    assert presence.handle_beat(beat("a", 2))
    assert f"{1:016x}" not in presence
    assert presence.present["a"].link == f"{2:016x}"


def test_a_restarted_gateway_replaces_the_one_that_was_killed(presence: Presence, clock: Clock) -> None:
    presence.handle_beat(beat("a", 1, instance=1))
    clock.now += 0.5
    assert not presence.handle_beat(beat("a", 2, instance=2))
    assert presence.present["a"].link == f"{2:016x}"
    clock.now += 0.5
    assert presence.expire()
    assert presence.present["a"].link == f"{2:016x}"


def test_a_connection_without_signs_of_life_yet_is_known_and_no_gateway(presence: Presence, clock: Clock) -> None:
    assert presence.note_sign("0" * 16)
    assert presence.present == {}
    clock.now += 0.5
    presence.note_sign("0" * 16)
    clock.now += 0.5
    assert not presence.expire()
    clock.now += 0.5
    assert presence.expire()
    assert "0" * 16 not in presence


def test_silence_is_not_held_against_others_by_a_listener_that_stood_still(presence: Presence, clock: Clock) -> None:
    presence.handle_beat(beat("a"))
    clock.now += 10
    presence.excuse()
    assert not presence.expire()
    assert list(presence.present) == ["a"]


def test_without_a_connection_no_gateway_is_there(presence: Presence) -> None:
    presence.handle_beat(beat("a"))
    presence.clear()
    assert presence.present == {}


def test_no_more_connections_are_remembered_than_there_may_be(
    presence: Presence, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MAX_GATEWAYS", 1)
    presence.handle_beat(beat("a", 1))
    assert not presence.handle_beat(beat("b", 2))
    assert not presence.note_sign(f"{2:016x}")
    assert list(presence.present) == ["a"]
