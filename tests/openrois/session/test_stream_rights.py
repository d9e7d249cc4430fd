"""What ends with the lease, and what with the role, that a stream needs."""

from openrois.auth.principal import LOCAL, Role
from openrois.session.stream_rights import StreamRight, StreamRights
from tests.support.authorization import principal

OPERATED = StreamRight(operated=True, role=Role.VISITOR)
LISTENING = StreamRight(role=Role.LISTENER, needs_role=True)


def rights() -> StreamRights:
    made = StreamRights()
    made.note_stream("a/1", "a/camera", OPERATED)
    made.note_stream("a/2", "a/camera", LISTENING)
    made.note_stream("a/3", "a/camera", StreamRight())
    made.note_stream("b/1", "b/camera", OPERATED)
    return made


def test_with_the_last_lease_of_an_engine_what_it_operated_is_lost() -> None:
    assert rights().lost_with("a/arm", ["b/arm"]) == ["a/1"]
    assert rights().lost_with("a/arm", ["a/leg"]) == []


def test_with_a_role_what_needs_it_is_lost_and_what_only_says_it_is_not() -> None:
    assert rights().lost_without(principal("operator", "*")) == ["a/2"]
    assert rights().lost_without(principal("listener")) == rights().lost_without(LOCAL) == []


def test_what_has_ended_cannot_be_lost() -> None:
    made = rights()
    for stream_id in ("a/1", "a/2", "a/3", "unknown"):
        made.forget_stream(stream_id)
    assert (made.lost_with("a/arm", []), made.lost_without(principal("viewer"))) == ([], [])
