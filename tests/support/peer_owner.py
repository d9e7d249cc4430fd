"""The owner of one peer connection, which notes what the peer reports."""

from openrois_signaling.messages import Answer, Bye, Candidate, CaptureClocks, Downward
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.network.turns import Ingress
from openrois_streaming.peer.input_channels import Channels
from openrois_streaming.peer.peer import Peer
from openrois_streaming.peer.stream import Stream
from openrois_streaming.stats import Counters
from openrois_streaming.tasks import OwnedTasks

from tests.support.streaming import VirtualClock, settle
from tests.support.viewing import FedPublisher, WirelessConnection


class Owner:
    """Owns one peer connection and remembers what it said."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.publisher = FedPublisher()
        self.failures: list[BaseException] = []
        self.said: list[Downward] = []
        self.ended: list[str] = []
        self.declined: list[str] = []
        self.changes = 0
        self.answers = 0
        self.tasks = OwnedTasks("peer", self.failures.append)
        self.peer = Peer(
            "engine/p",
            replaces="engine/o",
            ice_servers=(),
            network=NetworkSettings(),
            guarded=GuardFigures(),
            ingress=Ingress(),
            clock=self.clock,
            tasks=self.tasks,
            owner=self,
            channels=Channels,
        )
        self.connection = WirelessConnection.made[-1]

    def peer_says(self, message: Downward) -> None:
        self.said.append(message)

    def peer_answered(self) -> None:
        self.answers += 1

    def peer_changed(self, peer: Peer) -> None:
        self.changes += 1

    def peer_declined(self, peer: Peer, stream: Stream) -> None:
        self.declined.append(stream.stream_id)
        peer.detach(stream)

    def peer_ended(self, peer: Peer) -> None:
        self.ended.append(peer.peer_id)

    def peer_muted(self, reason: str) -> None:
        raise AssertionError(reason)

    def attach(self, name: str = "s") -> Stream:
        stream = Stream(name, "engine/Video", "video", self.publisher, ("video/VP8",), Counters())
        self.peer.attach(stream)
        return stream

    async def answer(self, generation: int = 1, sdp: str = "answer") -> None:
        await settle()
        await self.peer.apply_answer(Answer(peer_id="engine/p", generation=generation, sdp=sdp))

    async def trickle(self, candidate: str | None, generation: int = 1) -> None:
        await self.peer.add_candidate(
            Candidate(peer_id="engine/p", generation=generation, candidate=candidate, sdp_mid="0")
        )

    async def play(self) -> Stream:
        """A stream that is answered, connected and flowing."""
        stream = self.attach()
        await self.answer()
        self.connection.become("connected")
        await settle()
        await self.publisher.renditions("video/VP8")[0].show(keyframe=True)
        self.connection.report(1)
        return stream

    @property
    def clocks(self) -> list[CaptureClocks]:
        return [message for message in self.said if isinstance(message, CaptureClocks)]

    @property
    def reasons(self) -> list[str]:
        return [message.reason for message in self.said if isinstance(message, Bye)]
