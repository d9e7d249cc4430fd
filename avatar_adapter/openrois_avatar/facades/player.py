"""The signaling of one peer connection between a game engine and an application. Pure."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from openrois_signaling.messages import (
    CANDIDATES_LIMIT,
    REASON_LIMIT,
    SDP_LIMIT,
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
    """A stream that a player has to carry."""

    stream_id: str
    component_ref: str
    kind: MediaKind


class Player:
    """A player of a game engine, and the peer connection that an application knows it by.

    A faulty message of the game engine ends the player; a faulty message of the application is raised, and ends the
    player where it cannot be undone.

    Args:
        player_id: its id at the game engine.
        negotiation: its peer id at the application, and the state of its offers.
        streamer: the game engine.
        send: sends the application a message.
        permits: returns whether a candidate of the application may be used; raises InvalidCandidate for a malformed
            one.
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
        """The sections of the last offer to the application."""
        self._later: tuple[str, tuple[Section, ...]] | None = None
        """An offer that came while the last one was not answered."""
        self._early: list[Candidate] = []
        """The game engine's candidates before its first offer."""
        self._found = 0
        self._carried: Mapping[str, Carried] = {}
        """The streams of the last offer, by the mids of its sections."""
        self.answered_at: float | None = None
        """When the first answer was sent to the game engine."""

    @property
    def peer_id(self) -> str:
        """The peer id at the application."""
        return self._negotiation.peer_id

    @property
    def is_settled(self) -> bool:
        """Whether no offer is being negotiated."""
        return self._negotiation.state not in _UNSETTLED

    @property
    def carried(self) -> tuple[Carried, ...]:
        """The streams of the last offer."""
        return tuple(self._carried.values())

    def begin(self, now: float) -> None:
        """Note that the game engine was asked for an offer."""
        self._negotiation.change(now)

    def offered(self, sdp: str, wanted: Iterable[Carried], now: float) -> None:
        """Handle an offer of the game engine; the application gets it as soon as its last answer is there.

        Args:
            sdp: the description.
            wanted: the streams that the player has to carry, as far as they are offered.
            now: seconds.

        Raises:
            UnusableDescription: it cannot be passed on.
        """
        sections = sections_of(sdp)
        if any(section.kind == "application" for section in sections):
            raise UnusableDescription(
                "the game engine offers a data channel, which is not supported; offer audio and video only"
            )
        if self._negotiation.state is State.PREPARING or self._negotiation.change(now):
            self._offer(sdp, sections, wanted, now)
        else:
            self._later = sdp, sections

    def _offer(self, sdp: str, sections: tuple[Section, ...], wanted: Iterable[Carried], now: float) -> None:
        found = ((section_for(each.kind, sections), each) for each in wanted)
        self._told = sections
        self._carried = {section.mid: each for section, each in found if section is not None}
        if not self._carried:
            raise UnusableDescription("the game engine offers none of the connected streams")
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
            raise UnusableDescription(f"the description has more than {SDP_LIMIT} bytes, which is the limit") from error
        self._send(offer)
        early, self._early = self._early, []
        for candidate in early:
            self._send(candidate.model_copy(update={"generation": offer.generation}))

    def found(self, found: Found) -> None:
        """Handle a candidate of the game engine; a malformed one is dropped."""
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

    def apply_answer(self, answer: Answer, now: float) -> None:
        """Apply an answer of the application.

        Raises:
            UnexpectedAnswer: no offer waits for it.
            InvalidDescription: it does not match the offer and the connected streams; the player has to end.
            UnusableDescription: a later offer of the game engine cannot be passed on; the player has to end.
        """
        if self._negotiation.receive_answer(answer, now) is not Verdict.APPLY:
            raise UnexpectedAnswer(self._negotiation.why_stale(answer))
        try:
            check_answer(answer.sdp, self._told, self._carried.keys())
            sdp, candidates = split_candidates(answer.sdp)
        except UnusableDescription as error:
            raise InvalidDescription(str(error)) from error
        self._streamer.send_answer(self.player_id, sdp)
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

    def add_candidate(self, candidate: Candidate) -> None:
        """Handle a candidate of the application.

        Raises:
            StaleGeneration: it belongs to an earlier offer.
            TooManyCandidates: the application has sent the most allowed already.
            InvalidCandidate: it is malformed.
        """
        verdict = self._negotiation.candidate(candidate)
        if verdict is Verdict.FULL:
            raise TooManyCandidates(f"a peer may send at most {CANDIDATES_LIMIT} candidates")
        if verdict in {Verdict.STALE, Verdict.ENDED}:
            raise StaleGeneration("the candidate belongs to another offer")
        if verdict is Verdict.APPLY:
            self._pass_on(candidate.candidate, candidate.sdp_mid, candidate.sdp_m_line_index)

    def expire(self, now: float) -> bool:
        """Return whether an awaited message has not come in time, which ends the player."""
        return self._tell_end(self._negotiation.expire(now))

    def close(self, reason: str) -> None:
        """End the player for both sides; `reason` is a sentence for a person."""
        self._tell_end(self._negotiation.end_negotiation(reason[:REASON_LIMIT]))

    def leave(self) -> None:
        """End the player for the game engine; the application keeps its peer connection."""
        self._streamer.dismiss(self.player_id)

    def _tell_end(self, bye: Bye | None) -> bool:
        if bye is None:
            return False
        self._streamer.dismiss(self.player_id)
        self._send(bye)
        return True

    def _pass_on(self, candidate: str | None, mid: str | None, index: int | None) -> None:
        """Send the game engine a candidate; the end of candidates is not sent, as it is not needed.

        An application names the section by mid or by index, and game engines need both.
        """
        if not candidate or not self._permits(candidate):
            return
        mids = [section.mid for section in self._told]
        if index is None and mid in mids:
            index = mids.index(mid)
        elif mid is None and index is not None and index < len(mids):
            mid = mids[index]
        self._streamer.send_candidate(Found(self.player_id, candidate, mid, index))
