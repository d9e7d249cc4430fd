"""One peer connection between a game engine and an application: what both say about it passes through here. Pure."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from openrois_signaling.messages import (
    CANDIDATES_LIMIT,
    REASON_LIMIT,
    Answer,
    Bye,
    Candidate,
    Downward,
    MediaKind,
    StreamSection,
)
from openrois_signaling.negotiation import Negotiation, State, Verdict
from openrois_streaming.errors import (
    InvalidCandidate,
    InvalidDescription,
    StaleGeneration,
    TooManyCandidates,
    UnexpectedAnswer,
)
from pydantic import ValidationError

from openrois_avatar.facades.sections import (
    Section,
    UnusableDescription,
    check_answer,
    section_for,
    sections_of,
    split_candidates,
)
from openrois_avatar.facades.streamer import Found, Streamer

__all__ = ["Carried", "Player"]

_UNSETTLED: Final = frozenset({State.PREPARING, State.OFFERED, State.APPLYING})


@dataclass(frozen=True, slots=True)
class Carried:
    """A stream that a player is to carry."""

    stream_id: str
    component_ref: str
    kind: MediaKind


class Player:
    """A player of a game engine, and the peer connection that an application knows it by.

    What is wrong with what the game engine says ends the player; what is wrong with what the application says is
    raised, and ends it where it cannot be taken back.

    Args:
        player_id: what the game engine calls it.
        negotiation: what the application calls it, and where its offers stand.
        streamer: the game engine.
        send: sends the application a message.
        permits: tells whether a candidate of the application may be used, and raises InvalidCandidate for one that
            cannot be read.
    """

    def __init__(
        self,
        player_id: str,
        negotiation: Negotiation,
        streamer: Streamer,
        send: Callable[[Downward], None],
        permits: Callable[[str], bool],
    ) -> None:
        self.player_id = player_id
        self._negotiation = negotiation
        self._streamer = streamer
        self._send = send
        self._permits = permits
        self._told: tuple[Section, ...] = ()
        """The sections of the offer that the application has."""
        self._later: tuple[str, tuple[Section, ...]] | None = None
        """An offer that came while the one before was not answered."""
        self._early: list[Candidate] = []
        """The game engine's candidates from before its first offer."""
        self._found = 0
        self._carried: Mapping[str, Carried] = {}
        """What the last offer carries, by the names of its sections."""
        self.answered_at: float | None = None
        """When the first answer was handed to the game engine."""

    @property
    def peer_id(self) -> str:
        """What the application knows it by."""
        return self._negotiation.peer_id

    @property
    def is_settled(self) -> bool:
        """Whether neither side waits for the other."""
        return self._negotiation.state not in _UNSETTLED

    @property
    def carried(self) -> tuple[Carried, ...]:
        """The streams of the last offer."""
        return tuple(self._carried.values())

    def begin(self, now: float) -> None:
        """The game engine was asked for an offer."""
        self._negotiation.change(now)

    def offered(self, sdp: str, wanted: Iterable[Carried], now: float) -> None:
        """The game engine offers; the application gets it as soon as its last answer is there.

        Args:
            sdp: the description.
            wanted: what the player is to carry, as far as it is offered.
            now: seconds.

        Raises:
            UnusableDescription: it cannot be passed on.
        """
        sections = sections_of(sdp)
        if any(section.kind == "application" for section in sections):
            raise UnusableDescription("the game engine offers a data channel, which is not passed on")
        if self._negotiation.state is State.PREPARING or self._negotiation.change(now):
            self._offer(sdp, sections, wanted, now)
        else:
            self._later = sdp, sections

    def _offer(self, sdp: str, sections: tuple[Section, ...], wanted: Iterable[Carried], now: float) -> None:
        found = ((section_for(each.kind, sections), each) for each in wanted)
        self._told = sections
        self._carried = {section.mid: each for section, each in found if section is not None}
        if not self._carried:
            raise UnusableDescription("the game engine offers nothing of what was connected")
        self._negotiation.describe()
        streams = tuple(
            StreamSection(
                mid=mid,
                stream_id=each.stream_id,
                component_ref=each.component_ref,
                kind=each.kind,
                direction="recvonly",
            )
            for mid, each in self._carried.items()
        )
        try:
            offer = self._negotiation.made(sdp, streams, now)
        except ValidationError as error:
            raise UnusableDescription("the description is too long") from error
        self._send(offer)
        early, self._early = self._early, []
        for candidate in early:
            self._send(candidate.model_copy(update={"generation": offer.generation}))

    def found(self, found: Found) -> None:
        """The game engine has found a candidate; what cannot be one is dropped."""
        self._found += 1
        if self._found > CANDIDATES_LIMIT:
            return
        try:
            candidate = Candidate(
                peer_id=self.peer_id,
                generation=max(self._negotiation.generation, 1),
                candidate=found.candidate or None,
                sdp_mid=found.sdp_mid,
                sdp_m_line_index=found.sdp_m_line_index,
            )
        except ValidationError:
            return
        if self._negotiation.generation:
            self._send(candidate)
        else:
            self._early.append(candidate)

    def answer(self, answer: Answer, now: float) -> None:
        """The application answers.

        Raises:
            UnexpectedAnswer: no offer waits for it.
            InvalidDescription: it does not answer the offer, or takes what was not connected; the player has to end.
            UnusableDescription: what the game engine offered meanwhile cannot be passed on; the player has to end.
        """
        if self._negotiation.answer(answer, now) is not Verdict.APPLY:
            raise UnexpectedAnswer(self._negotiation.why_stale(answer))
        try:
            check_answer(answer.sdp, self._told, self._carried.keys())
            sdp, candidates = split_candidates(answer.sdp)
        except UnusableDescription as error:
            raise InvalidDescription(str(error)) from error
        self._streamer.answer(self.player_id, sdp)
        if self.answered_at is None:
            self.answered_at = now
        for line in candidates[:CANDIDATES_LIMIT]:
            with suppress(InvalidCandidate):
                self._pass_on(line.candidate, line.mid, line.index)
        for held in self._negotiation.applied(now):
            with suppress(InvalidCandidate):
                self._pass_on(held.candidate, held.sdp_mid, held.sdp_m_line_index)
        if self._later is not None:
            (sdp, sections), self._later = self._later, None
            self._negotiation.change(now)
            self._offer(sdp, sections, self.carried, now)

    def candidate(self, candidate: Candidate) -> None:
        """The application has found a candidate.

        Raises:
            StaleGeneration: it belongs to no offer that counts.
            TooManyCandidates: the application has sent as many as it may.
            InvalidCandidate: it cannot be read.
        """
        verdict = self._negotiation.candidate(candidate)
        if verdict is Verdict.FULL:
            raise TooManyCandidates(f"a peer may send {CANDIDATES_LIMIT} candidates")
        if verdict in {Verdict.STALE, Verdict.ENDED}:
            raise StaleGeneration("the candidate belongs to another offer")
        if verdict is Verdict.APPLY:
            self._pass_on(candidate.candidate, candidate.sdp_mid, candidate.sdp_m_line_index)

    def expire(self, now: float) -> bool:
        """Whether what is awaited has not come in time; then the player has ended."""
        return self._tell_end(self._negotiation.expire(now))

    def end(self, reason: str) -> None:
        """It is over for both; `reason` is a sentence for a person."""
        self._tell_end(self._negotiation.end(reason[:REASON_LIMIT]))

    def leave(self) -> None:
        """It is over for the game engine; the application keeps its end."""
        self._streamer.dismiss(self.player_id)

    def _tell_end(self, bye: Bye | None) -> bool:
        if bye is None:
            return False
        self._streamer.dismiss(self.player_id)
        self._send(bye)
        return True

    def _pass_on(self, candidate: str | None, mid: str | None, index: int | None) -> None:
        """Hand the game engine a candidate; that there are no more is not told, for it need not know.

        An application names its section in one way or the other, and game engines want to hear both.
        """
        if not candidate or not self._permits(candidate):
            return
        mids = [section.mid for section in self._told]
        if index is None and mid in mids:
            index = mids.index(mid)
        elif mid is None and index is not None and index < len(mids):
            mid = mids[index]
        self._streamer.find(Found(self.player_id, candidate, mid, index))
