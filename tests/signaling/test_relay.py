import pytest
from openrois_signaling.messages import CANDIDATES_LIMIT, Answer, Candidate, Restart
from openrois_signaling.relay import BURST, PEERS_PER_OWNER, RATE, Refused, Relay, Upward


class Ends:
    """Both ends of a relay: what reached the engines, and the time."""

    def __init__(self) -> None:
        self.now = 50.0
        self.forwarded: list[tuple[str, Upward]] = []
        self.refusal: Refused | None = None
        self.relay: Relay[str, str] = Relay(self.forward, lambda: self.now)

    async def forward(self, engine: str, message: Upward) -> None:
        self.forwarded.append((engine, message))
        if self.refusal is not None:
            raise self.refusal

    async def send(self, owner: str, message: Upward) -> str:
        """Send a message and return what its reply would say."""
        try:
            await self.relay.send(owner, message)
        except Refused as refusal:
            return refusal.return_code
        return "OK"


@pytest.fixture
def ends() -> Ends:
    ends = Ends()
    assert ends.relay.register("p", "alice", "avatar")
    return ends


def restart(peer_id: str = "p") -> Restart:
    return Restart(peer_id=peer_id)


def candidate(number: int = 0) -> Candidate:
    return Candidate(peer_id="p", generation=1, candidate=f"candidate:{number}", sdp_mid="0")


async def test_the_owners_messages_reach_the_engine_and_its_refusal_comes_back(ends: Ends) -> None:
    ends.refusal = Refused("BAD_PARAMETER", "garbage")
    sent: list[Upward] = [Answer(peer_id="p", generation=1, sdp="not looked at"), candidate(), restart()]
    for message in sent:
        assert await ends.send("alice", message) == "BAD_PARAMETER"
    assert ends.forwarded == [("avatar", message) for message in sent]


async def test_a_foreign_peer_cannot_be_told_from_an_unknown_one(ends: Ends) -> None:
    assert await ends.send("mallory", restart("p")) == "UNSUPPORTED"
    assert await ends.send("mallory", restart("q")) == "UNSUPPORTED"
    assert ends.forwarded == []


async def test_an_application_that_sends_too_fast_is_refused_and_hurts_no_other(ends: Ends) -> None:
    ends.relay.register("q", "bob", "avatar")
    codes = [await ends.send("alice", restart()) for _ in range(int(BURST) + 2)]
    assert codes == ["OK"] * int(BURST) + ["OUT_OF_RESOURCES"] * 2
    assert await ends.send("bob", restart("q")) == "OK"
    ends.now += 2.5 / RATE
    assert [await ends.send("alice", restart()) for _ in range(3)] == ["OK", "OK", "OUT_OF_RESOURCES"]
    ends.now += 1e6
    codes = [await ends.send("alice", restart()) for _ in range(int(BURST) + 1)]
    assert codes.count("OK") == BURST


async def test_guessing_peer_ids_is_limited_too(ends: Ends) -> None:
    codes = [await ends.send("mallory", restart(str(number))) for number in range(int(BURST) + 1)]
    assert codes == ["UNSUPPORTED"] * int(BURST) + ["OUT_OF_RESOURCES"]


async def test_a_peer_has_a_bounded_number_of_candidates(ends: Ends) -> None:
    for number in range(CANDIDATES_LIMIT):
        assert await ends.send("alice", candidate(number)) == "OK"
    assert await ends.send("alice", candidate()) == "OUT_OF_RESOURCES"
    assert await ends.send("alice", restart()) == "OK"
    assert len(ends.forwarded) == CANDIDATES_LIMIT + 1


def test_a_peer_keeps_its_two_ends(ends: Ends) -> None:
    assert ends.relay.register("p", "alice", "avatar")
    assert not ends.relay.register("p", "bob", "avatar")
    assert not ends.relay.register("p", "alice", "evil")
    assert ends.relay.owner("p", "avatar") == "alice"
    assert ends.relay.owner("p", "evil") is None
    assert ends.relay.owner("q", "avatar") is None
    ends.relay.forget_peer("p", "evil")
    ends.relay.forget_peer("q", "avatar")
    assert ends.relay.owner("p", "avatar") == "alice"
    ends.relay.forget_peer("p", "avatar")
    assert ends.relay.owner("p", "avatar") is None


def test_an_application_has_a_bounded_number_of_peers(ends: Ends) -> None:
    for number in range(PEERS_PER_OWNER - 1):
        assert ends.relay.register(str(number), "alice", "avatar")
    assert not ends.relay.register("one more", "alice", "avatar")
    assert ends.relay.register("p", "alice", "avatar")
    assert ends.relay.register("one more", "bob", "avatar")


async def test_a_failure_of_the_engines_side_passes_through() -> None:
    async def broken(engine: str, message: Upward) -> None:
        raise ConnectionError(engine)

    relay: Relay[str, str] = Relay(broken, lambda: 0.0)
    relay.register("p", "alice", "avatar")
    with pytest.raises(ConnectionError, match="avatar"):
        await relay.send("alice", restart())
