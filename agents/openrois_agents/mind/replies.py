"""Sentences that a mind without a language model says. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from openrois_agents.mind.placing import Place, side_of
from openrois_agents.tools.answer import Answer

__all__ = ["ability", "around", "distance", "faces", "failed", "listed", "misunderstood", "number_of", "refusal"]

_NEAREST: Final = 5
"""Things that are named; a longer list is not listened to."""
_REASONS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "Unsupported": "I cannot do that with this body.",
        "BadParameter": "I cannot do that with this body.",
        "OutOfResources": "I cannot do that just now.",
        "TimedOut": "That took too long, so I stopped.",
        "Aborted": "I was stopped.",
        "ConnectionLost": "I have lost my body for a moment.",
    }
)
_ABILITIES: Final[Mapping[str, str]] = MappingProxyType(
    {"gesture": "make gestures", "look_at": "look where you want", "go_to": "go to places"}
)


def failed(answer: Answer) -> bool:
    """Return whether a tool has failed; a stage says so."""
    return "failed" in answer.data


def refusal(answer: Answer) -> str:
    """Return why a tool has failed, for a visitor."""
    return _REASONS.get(answer.text.partition(":")[0], "That did not work.")


def listed(names: Sequence[str], last: str = "and") -> str:
    """Return names as a list in a sentence."""
    return f" {last} ".join(each for each in (", ".join(names[:-1]), *names[-1:]) if each)


def misunderstood(examples: Sequence[str]) -> str:
    """Return that a sentence was not understood, and what would be."""
    return f"I did not understand. You can say: {listed(examples, 'or')}."


def ability(tools: Iterable[str]) -> str:
    """Return what a body can do with these tools."""
    return f"I can {listed(['talk', *(what for tool, what in _ABILITIES.items() if tool in tools)])}."


def number_of(count: int, noun: str) -> str:
    """Return how many there are."""
    return f"{('no', 'one')[count]} {noun}" if count < 2 else f"{count} {noun}s"


def faces(count: int, noun: str) -> str:
    """Return what a camera notices."""
    return f"Through the camera I notice {number_of(count, noun)}."


def around(things: Mapping[str, Place], persons: Mapping[str, Place], at: Place | None) -> list[str]:
    """Return sentences on what is around a body; the nearest first, where it knows its place."""
    told = []
    if persons:
        told.append(f"On my floor there {'is' if len(persons) == 1 else 'are'} {number_of(len(persons), 'person')}.")
    if things:
        names = sorted(things, key=lambda name: 0.0 if at is None else things[name].distance(at))
        more = " and more" if len(names) > _NEAREST else ""
        told.append(f"Around me I know the {listed(names[:_NEAREST])}{more}.")
    return told


def distance(name: str, thing: Place, at: Place) -> str:
    """Return where a thing is, seen from a body."""
    metres = max(1, round(thing.distance(at)))
    return f"The {name} is about {number_of(metres, 'metre')} away, {side_of(thing, at)}."
