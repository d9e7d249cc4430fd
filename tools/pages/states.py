"""State tables as they are in the code: a row for each state, a column for each input."""

from collections.abc import Mapping, Sequence
from enum import Enum
from typing import TypeVar

from openrois_signaling import negotiation
from openrois_streaming import state

__all__ = ["negotiation_states", "stream_states"]

_State = TypeVar("_State", bound=Enum)
_Input = TypeVar("_Input", bound=Enum)


def stream_states() -> list[str]:
    """Return the phases of a stream with the status that each is reported as, and what follows each input."""
    notes = {phase: status.name for phase, status in state.STATUS.items()}
    return _table("phase", state.TRANSITIONS, list(state.StreamInput), "status", notes)


def negotiation_states() -> list[str]:
    """Return the states of the negotiation of a peer connection, and how long each may last."""
    notes = {each: f"{seconds:g} s" for each, (seconds, _) in negotiation.TIMEOUTS.items()}
    return _table("state", negotiation.TRANSITIONS, list(negotiation.Input), "at most", notes)


def _table(
    first: str,
    transitions: Mapping[_State, Mapping[_Input, _State]],
    inputs: Sequence[_Input],
    last: str,
    notes: Mapping[_State, str],
) -> list[str]:
    rows = [
        [str(each.value), *("" if to is None else str(to.value) for to in map(after.get, inputs)), notes.get(each, "")]
        for each, after in transitions.items()
        if after
    ]
    head = [first, *(f"*{each.value}*" for each in inputs), last]
    return [f"| {' | '.join(cells)} |" for cells in (head, ["-"] * len(head), *rows)]
