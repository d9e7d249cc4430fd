"""What an application sees of a game engine that does WebRTC itself: players come and go as its streams do."""

from collections.abc import Callable, Sequence

import pytest
from openrois_avatar.facades.streamer import Found, Heard, Left, NoRoom, NotOffered, Offered
from openrois_avatar.facades.viewed import Change
from openrois_avatar.facades.viewing import HANDOVER, Viewing
from openrois_signaling.messages import CANDIDATES_LIMIT, SDP_LIMIT, Answer, Bye, Candidate, Downward, IceServer, Offer
from openrois_signaling.negotiation import ANSWER_TIMEOUT, PREPARE_TIMEOUT
from openrois_streaming.errors import (
    InvalidCandidate,
    InvalidDescription,
    StaleGeneration,
    TooManyCandidates,
    TooManySections,
    UnexpectedAnswer,
    UnknownPeer,
    UnknownStream,
)

from tests.avatar.facades.test_sections import CHANNEL, media, sdp
from tests.support.clock import Clock

VIDEO, AUDIO = media("video", "0"), media("audio", "1", "sendrecv")
BOTH = sdp(VIDEO, AUDIO)
LINE = "candidate:1 1 udp 1 192.0.2.1 9 typ host"
BAD = "candidate:bad"


class Engine:
    """A `Streamer` that notes what it is told."""

    ready, name = True, "engine"

    def __init__(self) -> None:
        self.has_room = True
        self.players: list[str] = []
        self.dismissed: list[str] = []
        self.answers: list[tuple[str, str]] = []
        self.found: list[Found] = []
        self.servers: list[Sequence[IceServer]] = []

    def begin(self) -> None:
        """Nothing is said here."""

    def take(self, text: str) -> None:
        """Nothing is heard here."""

    def invite(self, player_id: str, ice_servers: Sequence[IceServer]) -> None:
        self.players.append(player_id)
        self.servers.append(ice_servers)

    def answer(self, player_id: str, sdp: str) -> None:
        self.answers.append((player_id, sdp))

    def find(self, found: Found) -> None:
        self.found.append(found)

    def dismiss(self, player_id: str) -> None:
        self.dismissed.append(player_id)


class House:
    """An application's viewing, with both of its neighbours in the test's hands."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.engine = Engine()
        self.there: Engine | None = self.engine
        self.sent: list[Downward] = []
        self.changes: list[str] = []
        self.peers = 0
        self.viewing = Viewing(self.mint, lambda: self.there, self.sent.append, self.changed, self.clock, self.permits)

    def mint(self) -> str:
        self.peers += 1
        return f"avatar/p{self.peers}"

    def changed(self, change: Change) -> None:
        assert change.component_ref.startswith("avatar/")
        self.changes.append(f"{change.stream_id} {change.status.value.removeprefix('STREAMING_')}")

    @staticmethod
    def permits(candidate: str) -> bool:
        if candidate == BAD:
            raise InvalidCandidate("bad")
        return "192.0.2" in candidate

    def told(self) -> list[str]:
        changes, self.changes = self.changes, []
        return changes

    def pass_time(self, seconds: float = 0.125) -> None:
        self.clock.now += seconds
        self.viewing.tick()

    def connect(self, *kinds: str) -> None:
        for kind in kinds:
            self.viewing.connect(kind, f"avatar/{kind}", "video" if kind == "video" else "audio")
        self.pass_time()

    def hears(self, make: Callable[[str], Heard]) -> None:
        self.viewing.hear(make(self.engine.players[-1]))

    def offers(self, text: str = BOTH) -> Offer:
        before = len(self.sent)
        self.hears(lambda player: Offered(player, text))
        offer = self.sent[before]
        assert isinstance(offer, Offer)
        return offer

    def answers(self, offer: Offer, more: str = "") -> None:
        mids = {each.mid for each in offer.streams}
        sections = [
            media(kind, mid, "recvonly" if mid in mids else "inactive", more=more)
            for kind, mid in (("video", "0"), ("audio", "1"))
            if f"m={kind}" in offer.sdp
        ]
        self.viewing.answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp(*sections)))

    def plays(self, *kinds: str) -> Offer:
        """Connects these, and both sides agree."""
        self.connect(*kinds)
        offer = self.offers()
        self.answers(offer)
        self.pass_time()
        return offer

    def byes(self) -> list[tuple[str, str]]:
        return [(each.peer_id, each.reason) for each in self.sent if isinstance(each, Bye)]


def streams(offer: Offer) -> dict[str, str]:
    return {each.stream_id: each.mid for each in offer.streams}


def test_what_is_connected_within_a_moment_is_offered_together_and_runs_when_it_is_answered() -> None:
    house = House()
    house.viewing.ice_servers = (IceServer(urls=("stun:stun.example.org",)),)
    house.connect("video", "audio")
    assert house.engine.servers == [house.viewing.ice_servers]
    assert house.viewing.status("video").value == "STREAMING_NOT_CONNECTED"
    offer = house.offers()
    assert (offer.sdp, offer.generation, offer.replaces) == (BOTH, 1, None)
    assert streams(offer) == {"video": "0", "audio": "1"}
    assert {each.direction for each in offer.streams} == {"recvonly"}
    assert house.told() == []
    house.answers(offer)
    assert house.engine.answers[0][0] == house.engine.players[0]
    house.pass_time()
    assert house.told() == ["video RUNNING", "audio RUNNING"]
    assert not house.viewing.is_over


def test_another_stream_comes_with_another_player_that_replaces_the_first() -> None:
    house = House()
    first = house.plays("video")
    house.connect("audio")
    second = house.offers()
    assert second.replaces == first.peer_id
    assert streams(second) == {"video": "0", "audio": "1"}
    assert house.engine.dismissed == []
    house.answers(second)
    house.pass_time()
    assert house.told() == ["video RUNNING", "audio RUNNING"]
    house.pass_time(HANDOVER)
    assert house.engine.dismissed == house.engine.players[:1]
    assert house.byes() == [(first.peer_id, "it was replaced")]
    assert house.told() == []


def test_a_disconnected_stream_leaves_with_its_player_and_the_last_one_ends_all() -> None:
    house = House()
    first = house.plays("video", "audio")
    house.viewing.disconnect("audio")
    house.pass_time()
    second = house.offers()
    assert streams(second) == {"video": "0"}
    house.answers(second)
    house.viewing.disconnect("video")
    house.pass_time()
    assert house.byes() == [(second.peer_id, "no stream is left to play"), (first.peer_id, "no stream is left to play")]
    assert house.told() == ["video RUNNING", "audio RUNNING", "audio NOT_CONNECTED", "video NOT_CONNECTED"]
    assert house.viewing.is_over
    with pytest.raises(UnknownStream):
        house.viewing.status("video")


def test_a_suspended_stream_has_no_player_and_comes_back_with_another() -> None:
    house = House()
    first = house.plays("video")
    house.told()
    for _ in range(2):
        house.viewing.suspend("video")
        house.pass_time()
    assert house.engine.dismissed == house.engine.players
    assert house.byes() == []
    assert house.told() == ["video SUSPENDED"]
    house.viewing.restart(first.peer_id)
    house.pass_time()
    assert len(house.engine.players) == 1
    assert not house.viewing.is_over
    house.viewing.resume("video")
    house.pass_time()
    second = house.offers()
    assert second.replaces == first.peer_id
    assert house.told() == []
    house.answers(second)
    house.pass_time()
    assert house.told() == ["video RESUMED", "video RUNNING"]


def test_what_is_suspended_beside_another_is_not_sent_longer_than_that_needs() -> None:
    house = House()
    house.plays("video", "audio")
    house.told()
    house.viewing.suspend("video")
    house.pass_time()
    second = house.offers()
    assert streams(second) == {"audio": "1"}
    assert house.engine.dismissed == []
    house.answers(second)
    house.pass_time()
    assert house.engine.dismissed == house.engine.players[:1]
    # A bye would say that the picture is over.
    assert house.byes() == []
    assert house.told() == ["video SUSPENDED"]


def test_all_suspended_while_one_player_replaces_another() -> None:
    house = House()
    first = house.plays("video")
    house.connect("audio")
    house.answers(house.offers())
    for kind in ("video", "audio"):
        house.viewing.suspend(kind)
    house.pass_time()
    assert sorted(house.engine.dismissed) == sorted(house.engine.players)
    house.viewing.end_peer("avatar/p2", "the page is closed")
    assert house.byes() == [("avatar/p2", "the page is closed")]
    with pytest.raises(UnknownPeer):
        house.viewing.end_peer(first.peer_id, "and again")


def test_a_restart_brings_a_new_player_once() -> None:
    house = House()
    first = house.plays("video")
    house.viewing.restart(first.peer_id)
    house.pass_time()
    house.viewing.restart(first.peer_id)
    house.viewing.restart("avatar/p2")
    house.pass_time()
    assert len(house.engine.players) == 2
    second = house.offers()
    assert second.replaces == first.peer_id
    # What is wanted meanwhile waits until this one is answered, and then takes the place of both.
    house.connect("audio")
    assert len(house.engine.players) == 2
    house.answers(second)
    house.pass_time()
    assert len(house.engine.players) == 3
    assert house.byes() == [(first.peer_id, "it was replaced")]
    with pytest.raises(UnknownPeer):
        house.viewing.restart("avatar/p9")


def test_a_player_that_cannot_be_had_in_time_leaves_the_one_before() -> None:
    house = House()
    first = house.plays("video")
    house.connect("audio")
    house.told()
    house.pass_time(PREPARE_TIMEOUT)
    assert house.byes() == [("avatar/p2", "no description could be made in time")]
    assert house.told() == ["audio NOT_CONNECTED"]
    assert house.viewing.status("video").value == "STREAMING_RUNNING"
    house.viewing.end_peer(first.peer_id, "the page is closed")
    house.pass_time()
    assert house.told() == ["video NOT_CONNECTED"]
    assert house.viewing.is_over


def test_an_offer_that_is_not_answered_ends_its_streams() -> None:
    house = House()
    house.connect("video")
    house.offers()
    house.pass_time(ANSWER_TIMEOUT)
    assert house.told() == ["video NOT_CONNECTED"]
    assert house.byes() == [("avatar/p1", "the offer was not answered in time")]
    assert house.engine.dismissed == house.engine.players


def test_it_is_known_for_how_long_no_offer_was_answered() -> None:
    house = House()
    house.connect("video")
    offer = house.offers()
    house.pass_time(3.0)
    assert house.viewing.unanswered_for() == pytest.approx(3.125)
    house.answers(offer)
    house.pass_time()
    assert house.viewing.unanswered_for() is None


def test_what_nobody_wants_any_more_is_not_waited_for() -> None:
    house = House()
    house.connect("video")
    house.offers()
    house.viewing.disconnect("video")
    house.pass_time()
    assert house.byes() == [("avatar/p1", "no stream is left to play")]
    assert house.viewing.is_over


def test_what_is_not_offered_is_not_connected_and_not_asked_for_again() -> None:
    house = House()
    house.connect("video", "audio")
    offer = house.offers(sdp(VIDEO))
    assert streams(offer) == {"video": "0"}
    house.answers(offer)
    house.pass_time()
    assert house.told() == ["audio NOT_CONNECTED", "video RUNNING"]
    with pytest.raises(NotOffered, match="sends no audio"):
        house.connect("audio")
    house.viewing.close("the game engine is gone")
    house.connect("audio")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (sdp(AUDIO), "the game engine offers nothing of what was connected"),
        (sdp(VIDEO, CHANNEL), "the game engine offers a data channel, which is not passed on"),
        ("hello", "the description is not SDP"),
        (BOTH + "a=x:" + "é" * (SDP_LIMIT // 2) + "\r\n", "the description is too long"),
    ],
)
def test_an_offer_that_cannot_be_passed_on_ends_its_player(text: str, why: str) -> None:
    house = House()
    house.connect("video")
    house.hears(lambda player: Offered(player, text))
    house.pass_time()
    assert house.byes() == [("avatar/p1", why)]
    assert house.told() == ["video NOT_CONNECTED"]
    assert house.engine.dismissed == house.engine.players


def test_an_answer_that_takes_more_than_was_connected_ends_its_player() -> None:
    house = House()
    house.connect("video")
    offer = house.offers()
    wrong = sdp(media("video", "0", "recvonly"), media("audio", "1", "recvonly"))
    with pytest.raises(InvalidDescription, match="section 1 was not connected"):
        house.viewing.answer(Answer(peer_id=offer.peer_id, generation=1, sdp=wrong))
    assert house.engine.answers == []
    assert house.byes() == [(offer.peer_id, "section 1 was not connected: it must be answered inactive")]


def test_a_game_engine_may_offer_anew_and_waits_for_the_answer_before() -> None:
    house = House()
    house.connect("video")
    first = house.offers()
    house.hears(lambda player: Offered(player, sdp(VIDEO)))
    assert house.sent == [first]
    house.answers(first)
    second = house.sent[-1]
    assert isinstance(second, Offer)
    assert (second.sdp, second.generation, second.peer_id) == (sdp(VIDEO), 2, first.peer_id)
    with pytest.raises(UnexpectedAnswer):
        house.answers(first)
    house.answers(second)
    third = house.offers(BOTH)
    assert third.generation == 3
    assert streams(third) == {"video": "0"}


def test_a_later_offer_that_cannot_be_passed_on_ends_the_player_with_the_answer() -> None:
    house = House()
    house.connect("video")
    first = house.offers()
    house.hears(lambda player: Offered(player, sdp(AUDIO)))
    with pytest.raises(InvalidDescription, match="nothing of what was connected"):
        house.answers(first)
    assert house.viewing.is_over is False
    house.pass_time()
    assert house.viewing.is_over


def test_candidates_of_the_game_engine_follow_its_offer() -> None:
    house = House()
    house.connect("video")
    for found in (LINE, "x" * 2000):
        house.hears(lambda player, found=found: Found(player, found, "0", 0))  # type: ignore[misc]
    assert house.sent == []
    house.offers()
    house.hears(lambda player: Found(player, "", None, None))
    house.hears(lambda player: Found(player, LINE, None, None))
    got = [each for each in house.sent[1:] if isinstance(each, Candidate)]
    assert [(each.candidate, each.sdp_mid, each.generation) for each in got] == [(LINE, "0", 1), (None, None, 1)]
    for _ in range(CANDIDATES_LIMIT):
        house.hears(lambda player: Found(player, LINE, "0", 0))
    assert len([each for each in house.sent if isinstance(each, Candidate)]) < CANDIDATES_LIMIT


def test_candidates_of_the_application_are_checked_one_by_one_and_wait_for_its_answer() -> None:
    house = House()
    house.connect("video")
    offer = house.offers()

    def finds(candidate: str | None, generation: int = 1) -> None:
        mid = None if candidate is None else "0"
        house.viewing.candidate(
            Candidate(peer_id=offer.peer_id, generation=generation, candidate=candidate, sdp_mid=mid)
        )

    finds(LINE)
    finds(BAD)
    house.answers(offer, more=f"a={LINE} in answer\r\na={BAD}\r\na=candidate:10.0.0.1\r\n")
    assert [each.candidate for each in house.engine.found] == [f"{LINE} in answer", f"{LINE} in answer", LINE]
    assert LINE not in house.engine.answers[0][1]
    assert {(each.sdp_mid, each.sdp_m_line_index) for each in house.engine.found} == {("0", 0), ("1", 1)}
    finds(LINE)
    finds("candidate:elsewhere")
    finds(None)
    assert len(house.engine.found) == 4
    with pytest.raises(InvalidCandidate):
        finds(BAD)
    with pytest.raises(StaleGeneration):
        finds(LINE, 2)
    for _ in range(CANDIDATES_LIMIT - 6):
        finds(None)
    with pytest.raises(TooManyCandidates):
        finds(LINE)
    with pytest.raises(UnknownPeer):
        house.viewing.candidate(Candidate(peer_id="avatar/p9", generation=1, candidate=None))


@pytest.mark.parametrize(
    ("mid", "index", "passed_on"),
    [("1", None, ("1", 1)), (None, 1, ("1", 1)), ("1", 1, ("1", 1)), ("x", None, ("x", None)), (None, 7, (None, 7))],
)
def test_a_candidate_names_its_section_both_ways(
    mid: str | None, index: int | None, passed_on: tuple[str | None, int | None]
) -> None:
    house = House()
    offer = house.plays("video", "audio")
    found = Candidate(peer_id=offer.peer_id, generation=1, candidate=LINE, sdp_mid=mid, sdp_m_line_index=index)
    house.viewing.candidate(found)
    assert [(each.sdp_mid, each.sdp_m_line_index) for each in house.engine.found] == [passed_on]


def test_a_game_engine_that_ends_a_player_ends_its_streams_and_no_others() -> None:
    house = House()
    house.plays("video")
    house.told()
    house.viewing.hear(Left("somebody else's", "?"))
    house.connect("audio")
    house.hears(lambda player: Left(player, "overloaded"))
    house.pass_time()
    assert house.byes() == [("avatar/p2", "overloaded")]
    assert house.told() == ["audio NOT_CONNECTED"]


def test_one_stream_of_each_kind_as_long_as_there_is_room() -> None:
    house = House()
    house.plays("video")
    with pytest.raises(TooManySections, match="a video stream already"):
        house.connect("video")
    house.engine.has_room = False
    house.connect("audio")
    house.viewing.close("the application is gone")
    with pytest.raises(NoRoom):
        house.connect("video")
    house.there = None
    with pytest.raises(NoRoom):
        house.connect("video")


def test_a_game_engine_without_room_for_two_gets_the_second_player_when_the_first_is_gone() -> None:
    house = House()
    first = house.plays("video")
    house.engine.has_room = False
    house.connect("audio")
    assert house.engine.dismissed == house.engine.players
    house.pass_time()
    house.engine.has_room = True
    house.pass_time()
    second = house.offers()
    assert second.replaces == first.peer_id
    assert house.byes() == []


def test_a_place_that_does_not_come_is_not_awaited_for_ever() -> None:
    house = House()
    first = house.plays("video")
    house.told()
    house.engine.has_room = False
    house.viewing.restart(first.peer_id)
    house.pass_time()
    house.pass_time(PREPARE_TIMEOUT)
    assert house.byes() == [(first.peer_id, "the game engine takes no further viewer")]
    assert house.told() == ["video NOT_CONNECTED"]


def test_a_game_engine_that_is_gone_when_a_player_is_wanted() -> None:
    house = House()
    house.plays("video")
    house.viewing.suspend("video")
    house.pass_time()
    house.there = None
    house.viewing.resume("video")
    house.pass_time()
    assert house.told()[-1] == "video NOT_CONNECTED"
    assert house.byes()[-1] == ("avatar/p1", "the game engine is gone")


def test_a_resumed_stream_that_was_not_yet_let_go_goes_on() -> None:
    house = House()
    house.plays("video")
    house.viewing.suspend("video")
    house.viewing.resume("video")
    house.pass_time()
    assert len(house.engine.players) == 1
    assert house.viewing.status("video").value == "STREAMING_RUNNING"


def test_an_application_that_is_done_with_the_player_before_says_so() -> None:
    house = House()
    first = house.plays("video")
    house.connect("audio")
    house.viewing.end_peer(first.peer_id, "replaced")
    house.answers(house.offers())
    house.pass_time()
    assert house.byes() == [(first.peer_id, "replaced")]
    assert house.told() == ["video RUNNING", "audio RUNNING"]
