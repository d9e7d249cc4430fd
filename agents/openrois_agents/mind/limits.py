"""Limits of conversations: how much of a mind one conversation and one day may use. Pure."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import date
from typing import Final

__all__ = ["CONVERSATION", "DAY", "Budget", "Limits", "Used"]


@dataclass(frozen=True, slots=True)
class Limits:
    """How much may be used.

    Attributes:
        turns: what visitors say and the mind answers.
        tokens: that a language model reads and writes.
        sound: seconds that the mind speaks.
    """

    turns: int
    tokens: int
    sound: float


CONVERSATION: Final = Limits(40, 200_000, 900.0)
"""Of one conversation, unless the command line says otherwise."""

DAY: Final = Limits(1_000, 2_000_000, 14_400.0)
"""Of one day, unless the command line says otherwise."""


@dataclass(frozen=True, slots=True)
class Used:
    """How much was used; see `Limits`.

    Attributes:
        day: on which.
    """

    day: date
    turns: int = 0
    tokens: int = 0
    sound: float = 0.0


_CONVERSATION_IS_OVER: Final = "We have talked for a long time now. I have to end here; thank you for the conversation."
_DAY_IS_OVER: Final = "I have talked as much as I may today. Please come back tomorrow."


class Budget:
    """What is left for this conversation and this day.

    It errs to the cheap side: only a later date begins a new day. Where a clock is set back the counts stay, and what
    was counted at a date in the future counts until then.

    Args:
        conversation: the limits of a conversation.
        day: the limits of a day.
        today: returns the date.
        used: what this day has used before; an earlier day's is forgotten.
        keep: told of each change of what the day has used.
    """

    def __init__(
        self,
        conversation: Limits,
        day: Limits,
        today: Callable[[], date],
        used: Used | None = None,
        keep: Callable[[Used], None] = lambda _used: None,
    ) -> None:
        self._of_conversation = conversation
        self._of_day = day
        self._today = today
        self._keep = keep
        self._day = Used(today()) if used is None else used
        self._conversation = Used(today())

    def begin_conversation(self) -> None:
        """Forget what the conversation before has used."""
        self._conversation = Used(self._today())

    def refusal(self) -> str:
        """Return why there may be no further turn, as a polite sentence; nothing where there may be one."""
        if _reached(self._of_day, self._used_today()):
            return _DAY_IS_OVER
        return _CONVERSATION_IS_OVER if _reached(self._of_conversation, self._conversation) else ""

    @property
    def tokens_left(self) -> int:
        """Tokens that the conversation and the day may still use."""
        day = self._of_day.tokens - self._used_today().tokens
        return max(0, min(day, self._of_conversation.tokens - self._conversation.tokens))

    def count_turn(self) -> None:
        """Count a turn that begins."""
        self._count(turns=1)

    def count_tokens(self, number: int) -> None:
        """Count tokens that a language model has read or written."""
        self._count(tokens=number)

    def count_sound(self, seconds: float) -> None:
        """Count seconds that the mind has spoken."""
        self._count(sound=seconds)

    def _count(self, turns: int = 0, tokens: int = 0, sound: float = 0.0) -> None:
        self._conversation = _more(self._conversation, turns, tokens, sound)
        self._day = _more(self._used_today(), turns, tokens, sound)
        self._keep(self._day)

    def _used_today(self) -> Used:
        today = self._today()
        if self._day.day < today:
            self._day = Used(today)
        return self._day


def _more(used: Used, turns: int, tokens: int, sound: float) -> Used:
    return replace(used, turns=used.turns + turns, tokens=used.tokens + tokens, sound=used.sound + sound)


def _reached(limits: Limits, used: Used) -> bool:
    return used.turns >= limits.turns or used.tokens >= limits.tokens or used.sound >= limits.sound
