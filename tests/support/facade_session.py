"""The session of an application with a game engine that does WebRTC itself; the test plays both."""

from collections.abc import Callable, Sequence

from openrois_avatar.facades.session import FacadeSession
from openrois_avatar.facades.session_streams import Change
from openrois_avatar.facades.streamer import Found, Heard, Offered
from openrois_signaling.messages import Answer, Bye, Downward, IceServer, Offer
from openrois_streaming.errors import InvalidCandidate

from tests.support.clock import Clock


def sdp(*sections: str, session: str = "") -> str:
    return "v=0\r\no=- 1 2 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\n" + session + "".join(sections)


def media(kind: str, mid: str, way: str = "sendonly", port: int = 9, more: str = "") -> str:
    line = f"a={way}\r\n" if way else ""
    return f"m={kind} {port} UDP/TLS/RTP/SAVPF 96 97\r\na=mid:{mid}\r\n{line}{more}"


CHANNEL = "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\na=mid:2\r\n"
VIDEO, AUDIO = media("video", "0"), media("audio", "1", "sendrecv")
BOTH = sdp(VIDEO, AUDIO)
LINE = "candidate:1 1 udp 1 192.0.2.1 9 typ host"
BAD = "candidate:bad"


class Engine:
    """A `Streamer` that notes its calls."""

    ready, name = True, "engine"

    def __init__(self) -> None:
        self.has_room = True
        self.players: list[str] = []
        self.dismissed: list[str] = []
        self.answers: list[tuple[str, str]] = []
        self.found: list[Found] = []
        self.servers: list[Sequence[IceServer]] = []

    def begin(self) -> None:
        """Nothing is sent here."""

    def handle_message(self, text: str) -> None:
        """Nothing is received here."""

    def invite(self, player_id: str, ice_servers: Sequence[IceServer]) -> None:
        self.players.append(player_id)
        self.servers.append(ice_servers)

    def send_answer(self, player_id: str, sdp: str) -> None:
        self.answers.append((player_id, sdp))

    def send_candidate(self, found: Found) -> None:
        self.found.append(found)

    def dismiss(self, player_id: str) -> None:
        self.dismissed.append(player_id)


class SessionHarness:
    """The session of an application, with its engine and its application played by the test."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.engine = Engine()
        self.there: Engine | None = self.engine
        self.sent: list[Downward] = []
        self.changes: list[str] = []
        self.peers = 0
        self.session = FacadeSession(
            self.mint, lambda: self.there, self.sent.append, self.changed, self.clock, self.permits
        )

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
        self.session.tick()

    def connect(self, *kinds: str) -> None:
        for kind in kinds:
            self.session.connect(kind, f"avatar/{kind}", "video" if kind == "video" else "audio")
        self.pass_time()

    def hears(self, make: Callable[[str], Heard]) -> None:
        self.session.handle_engine_message(make(self.engine.players[-1]))

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
        self.session.apply_answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp(*sections)))

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
