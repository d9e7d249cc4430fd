"""The engine's half of offer and answer for one peer connection. Pure: no I/O, and the time is an argument.

The engine always offers, the application answers (RFC 8829 with fixed roles, so there is no glare). The owner of the
peer connection tells a `Negotiation` what happened and does what it then says: make an offer, apply an answer, add
candidates, or end. At most one offer is unanswered; what changes meanwhile goes into the next one. Times are seconds
of one monotonic clock.
"""

from enum import Enum

from openrois_signaling.messages import CANDIDATES_LIMIT, Answer, Bye, Candidate, Offer, StreamSection

PREPARE_TIMEOUT = 5.0
"""Seconds the engine may take to make a description; gathering through an unreachable STUN server takes this long."""

ANSWER_TIMEOUT = 10.0
"""Seconds the application has to answer. With `PREPARE_TIMEOUT`, an unanswered stream lives 15 s at most."""

APPLY_TIMEOUT = 5.0
"""Seconds the engine may take to apply an answer."""


class State(Enum):
    """The states of the negotiation of one peer."""

    STABLE = "stable"
    """Nothing is pending: no offer yet, or the last one is answered and applied."""
    PREPARING = "preparing"
    """The engine is making a description."""
    OFFERED = "offered"
    """An offer is out and not answered."""
    APPLYING = "applying"
    """The engine is applying the answer."""
    ENDED = "ended"
    """The peer is gone for good."""


class Input(Enum):
    """The inputs of a negotiation."""

    CHANGE = "change"
    """The sections changed."""
    MADE = "made"
    """The description that was being made is there."""
    ANSWER = "answer"
    """The answer to the current offer arrived."""
    APPLIED = "applied"
    """That answer has been applied."""
    END = "end"
    """Either side ends the peer, or it took too long."""


TRANSITIONS: dict[State, dict[Input, State]] = {
    State.STABLE: {Input.CHANGE: State.PREPARING, Input.END: State.ENDED},
    State.PREPARING: {Input.CHANGE: State.PREPARING, Input.MADE: State.OFFERED, Input.END: State.ENDED},
    State.OFFERED: {Input.CHANGE: State.OFFERED, Input.ANSWER: State.APPLYING, Input.END: State.ENDED},
    State.APPLYING: {Input.CHANGE: State.APPLYING, Input.APPLIED: State.STABLE, Input.END: State.ENDED},
    State.ENDED: {},
}
"""All legal transitions. A change in a busy state is remembered; `applied` then says that a further offer is due."""

TIMEOUTS: dict[State, tuple[float, str]] = {
    State.PREPARING: (PREPARE_TIMEOUT, "no description could be made in time"),
    State.OFFERED: (ANSWER_TIMEOUT, "the offer was not answered in time"),
    State.APPLYING: (APPLY_TIMEOUT, "the answer could not be applied in time"),
}
"""How long a state may last, and the reason of the bye when it lasts longer."""


class IllegalTransition(RuntimeError):
    """An input that the current state does not have; nothing was changed. The engine's mistake, never the peer's."""


class Verdict(Enum):
    """The verdict on a message from the application."""

    APPLY = "apply"
    """Apply it now."""
    HELD = "held"
    """Kept; `applied` returns it when the description it belongs to is in place."""
    STALE = "stale"
    """Dropped: its generation is not the one that is awaited."""
    FULL = "full"
    """Dropped: the peer sent as many candidates as it may."""
    ENDED = "ended"
    """Dropped: the peer has ended."""


class Negotiation:
    """Offer and answer of the peer connection `peer_id`, which takes the place of `replaces` if that is given."""

    def __init__(self, peer_id: str, replaces: str | None = None) -> None:
        self.peer_id = peer_id
        self.replaces = replaces
        self._state = State.STABLE
        self._since = 0.0
        self._generation = 0
        self._answered = 0
        self._dirty = False
        self._held: list[Candidate] = []
        self._candidates = 0

    @property
    def state(self) -> State:
        """The present state."""
        return self._state

    @property
    def generation(self) -> int:
        """The number of the newest offer; 0 before the first."""
        return self._generation

    @property
    def answered(self) -> int:
        """The generation of the newest answer that is in place; 0 before the first."""
        return self._answered

    @property
    def dirty(self) -> bool:
        """Whether something changed that the newest offer does not contain."""
        return self._dirty

    def change(self, now: float) -> bool:
        """Note changed sections. True: make a description (`describe`, then `made`). False: it goes into the next.

        Raises:
            IllegalTransition: the peer has ended.
        """
        idle = self._state is State.STABLE
        self._move(Input.CHANGE, now)
        self._dirty = not idle
        return idle

    def describe(self) -> None:
        """The description is made from the sections as they are now, so it says all that changed until here.

        Raises:
            IllegalTransition: none was to be made.
        """
        self._legal(Input.MADE)
        self._dirty = False

    def made(self, sdp: str, streams: tuple[StreamSection, ...], now: float) -> Offer:
        """The description `sdp` with its `streams` is there; returns the offer to send.

        Raises:
            IllegalTransition: none was being made.
            pydantic.ValidationError: it exceeds a limit of the messages; the caller ends the peer.
        """
        self._legal(Input.MADE)
        generation = self._generation + 1
        offer = Offer(
            peer_id=self.peer_id,
            generation=generation,
            sdp=sdp,
            streams=streams,
            replaces=self.replaces if generation == 1 else None,
        )
        self._move(Input.MADE, now)
        self._generation = generation
        return offer

    def receive_answer(self, answer: Answer, now: float) -> Verdict:
        """Judge an answer: APPLY (and then call `applied`, or `end_negotiation` if that fails), STALE or ENDED."""
        if self._state is State.ENDED:
            return Verdict.ENDED
        if self._state is not State.OFFERED or answer.generation != self._generation:
            return Verdict.STALE
        self._move(Input.ANSWER, now)
        return Verdict.APPLY

    def why_stale(self, answer: Answer) -> str:
        """Return what is wrong with an answer that was `STALE`, as a sentence for a person."""
        is_known = answer.generation <= self._generation
        known, unknown = "the offer of generation {} has been answered already", "there was no offer of generation {}"
        said = (known if is_known else unknown).format(answer.generation)
        if self._state is State.OFFERED:
            said += f"; that of generation {self._generation} awaits its answer"
        return said

    def applied(self, now: float) -> tuple[Candidate, ...]:
        """Note that the answer is in place; return the candidates that waited for it. Then check `dirty`.

        Raises:
            IllegalTransition: no answer was being applied.
        """
        self._move(Input.APPLIED, now)
        self._answered = self._generation
        held, self._held = tuple(self._held), []
        return held

    def candidate(self, candidate: Candidate) -> Verdict:
        """Judge a candidate: APPLY, HELD, STALE, FULL or ENDED.

        All generations of a peer share one ICE session (a restart is a new peer), so a candidate of the answer in
        place is good while a further offer is out. What belongs to an older answer, or to no offer, is stale.
        """
        if self._state is State.ENDED:
            return Verdict.ENDED
        if not max(self._answered, 1) <= candidate.generation <= self._generation:
            return Verdict.STALE
        if self._candidates >= CANDIDATES_LIMIT:
            return Verdict.FULL
        self._candidates += 1
        if candidate.generation == self._answered:
            return Verdict.APPLY
        self._held.append(candidate)
        return Verdict.HELD

    def end_negotiation(self, reason: str) -> Bye | None:
        """End the peer; return the bye to send, or None if it had ended before."""
        if self._state is State.ENDED:
            return None
        self._move(Input.END, self._since)
        self._held.clear()
        return Bye(peer_id=self.peer_id, reason=reason)

    def deadline(self) -> float | None:
        """Return when `expire` is due; None while nothing is awaited."""
        if self._state not in TIMEOUTS:
            return None
        return self._since + TIMEOUTS[self._state][0]

    def excuse(self, seconds: float, now: float) -> None:
        """Extend the deadline by a pause of this process that ended now: what is awaited may have come unread."""
        self._since = min(now, self._since + seconds)

    def expire(self, now: float) -> Bye | None:
        """End the peer if its deadline has come; returns the bye to send, or None."""
        deadline = self.deadline()
        if deadline is None or now < deadline:
            return None
        return self.end_negotiation(TIMEOUTS[self._state][1])

    def _legal(self, event: Input) -> State:
        try:
            return TRANSITIONS[self._state][event]
        except KeyError:
            raise IllegalTransition(f"{event.value} while {self._state.value}") from None

    def _move(self, event: Input, now: float) -> None:
        state = self._legal(event)
        if state is not self._state:
            self._state, self._since = state, now
