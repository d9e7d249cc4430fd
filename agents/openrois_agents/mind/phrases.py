"""What can be said to a mind without a language model: a grammar for the recogniser, and what sentences mean. Pure."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from openrois_agents.mind.requests import (
    GESTURE_SENTENCES,
    OTHER_WORDS,
    POLITE_AFTER,
    POLITE_BEFORE,
    REQUESTS,
    Request,
)
from openrois_agents.tools.abilities import ABILITIES
from openrois_agents.tools.names import Vocabulary

__all__ = ["Intent", "Phrases", "make_phrases", "spoken_name"]

_ONES: Final = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"),
    *("thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen"),
)
_TENS: Final = ("", "", "twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_PART: Final = re.compile(r"\d+|[^\W\d_]+(?:'[^\W\d_]+)*")
_WORD: Final = re.compile(r"[a-z]+(?:'[a-z]+)*")
_SLOT: Final = re.compile(r"\{(\w+)\}")
_STOP: Final = next(each.sentences for each in REQUESTS if each.intent == "stop")
_ROOM: Final = 600
"""Words of all names together; a body takes a grammar of 2,000 words in which each stands up to twice."""


@dataclass(frozen=True, slots=True)
class Intent:
    """What a sentence means.

    Attributes:
        name: one of the intents of `REQUESTS`.
        argument: the gesture, place or direction, as the tools take it; empty where the intent needs none.
    """

    name: str
    argument: str = ""


@dataclass(frozen=True, slots=True)
class Phrases:
    """What can be said.

    Attributes:
        grammar: in JSGF; what it has besides the sentences catches speech that is none of them.
        examples: a sentence for each thing that can be said.
        names: the words of gestures and places in the grammar.
        left_out: names of gestures and places that the recogniser cannot hear.
        wake_word: with which every sentence has to begin; empty where none has to.
        meanings: what the sentences mean.
        requests: the sentences around which a "please" may stand.
    """

    grammar: str
    examples: tuple[str, ...]
    names: frozenset[str]
    left_out: tuple[str, ...]
    wake_word: str
    meanings: Mapping[str, Intent]
    requests: frozenset[str]

    def is_addressed(self, text: str) -> bool:
        """Return whether a text begins with the wake word, where there is one."""
        wake = self.wake_word.split()
        return _plain(text)[: len(wake)] == wake

    def understand(self, text: str) -> Intent | None:
        """Return what a text means; None where it is no sentence of these, or begins without the wake word."""
        if not self.is_addressed(text):
            return None
        said = " ".join(_plain(text)[len(self.wake_word.split()) :])
        if said in self.meanings:
            return self.meanings[said]
        bare = next((each for each in _without_politeness(said) if each in self.requests), None)
        return None if bare is None else self.meanings[bare]


def make_phrases(
    vocabulary: Vocabulary,
    tools: Collection[str] = tuple(ABILITIES),
    *,
    wake_word: str = "",
    unknown: Collection[str] = (),
) -> Phrases:
    """Return what can be said.

    Args:
        vocabulary: has the names of gestures and places.
        tools: what the bodies can do, of `ABILITIES`.
        wake_word: with which every sentence has to begin; empty where none has to.
        unknown: words that the recogniser does not know.
    """
    wake_word = " ".join(_plain(wake_word))
    wanted = (*(vocabulary.gestures if "gesture" in tools else ()), *vocabulary.places)
    said = _spoken(wanted, frozenset(unknown))
    places = {said[name]: name for name in vocabulary.places if name in said}
    gestures = [name for name in wanted if name in said and name not in vocabulary.places]
    slots = {"place": places, "gesture": {said[name]: name for name in gestures if name not in GESTURE_SENTENCES}}
    requests = [
        *(each for each in REQUESTS if each.tool in {"", *tools}),
        *(
            Request("gesture", GESTURE_SENTENCES[name], name, "gesture", is_request=True)
            for name in gestures
            if name in GESTURE_SENTENCES
        ),
    ]
    meanings: dict[str, Intent] = {}
    examples: list[str] = []
    for request in requests:
        filled = [each for sentence in request.sentences for each in _filled(sentence, request, slots)]
        examples += [sentence for sentence, _ in filled[:1]]
        for sentence, intent in filled:
            meanings.setdefault(sentence, intent)
    return Phrases(
        _grammar(wake_word, requests, slots),
        tuple(examples),
        frozenset(word for each in said.values() for word in each.split()),
        tuple(name for name in wanted if name not in said),
        wake_word,
        meanings,
        frozenset(
            sentence
            for request in requests
            if request.is_request
            for form in request.sentences
            for sentence, _ in _filled(form, request, slots)
        ),
    )


def _spoken(names: Iterable[str], unknown: frozenset[str]) -> dict[str, str]:
    """Return how names are said, of as many as a grammar has room for."""
    said: dict[str, str] = {}
    room = _ROOM
    for name in names:
        words = spoken_name(name).split()
        if words and len(words) <= room and not unknown & set(words):
            said[name] = " ".join(words)
            room -= len(words)
    return said


def spoken_name(name: str) -> str:
    """Return a name as it is said, in English letters; empty where it has others, or a large number."""
    parts = _PART.findall(name.lower())
    words = [_number(int(each)) if each.isdecimal() and len(each) < 3 else each for each in parts]
    spoken = " ".join(words)
    return spoken if all(_WORD.fullmatch(each) for each in spoken.split()) else ""


def _number(value: int) -> str:
    if value < len(_ONES):
        return _ONES[value]
    tens, ones = divmod(value, 10)
    return f"{_TENS[tens]} {_ONES[ones]}" if ones else _TENS[tens]


def _plain(text: str) -> list[str]:
    """Return the words of a text in lower case, without punctuation."""
    return _WORD.findall(text.lower().replace("\u2019", "'"))


def _filled(sentence: str, request: Request, slots: Mapping[str, Mapping[str, str]]) -> Iterator[tuple[str, Intent]]:
    """Return a sentence with each name in its slot, and what it means then."""
    slot = _SLOT.search(sentence)
    if slot is None:
        yield sentence, Intent(request.intent, request.argument)
        return
    for spoken, name in slots[slot[1]].items():
        yield sentence.replace(slot[0], spoken), Intent(request.intent, name)


def _without_politeness(said: str) -> Iterator[str]:
    """Return what may be left of a sentence behind and before words of politeness."""
    for before in ("", *(f"{each} " for each in POLITE_BEFORE)):
        for after in ("", *(f" {each}" for each in POLITE_AFTER)):
            if said.startswith(before) and said.endswith(after):
                yield said.removeprefix(before).removesuffix(after)


def _grammar(wake_word: str, requests: Iterable[Request], slots: Mapping[str, Mapping[str, str]]) -> str:
    """Return the grammar in JSGF."""
    forms: dict[bool, list[str]] = {True: [], False: []}
    before: dict[tuple[bool, str], list[str]] = {}
    for request in requests:
        for sentence in request.sentences:
            slot = _SLOT.search(sentence)
            if slot is None:
                forms[request.is_request].append(sentence)
            elif slots[slot[1]]:
                before.setdefault((request.is_request, slot[1]), []).append(sentence.removesuffix(slot[0]))
    for (is_request, name), beginnings in before.items():
        # A recogniser limits how long a grammar is when all rules are written out: names stand in it once or twice.
        forms[is_request].append(f"({'| '.join(beginnings)}) <{name}>")
    rules: dict[str, Iterable[str]] = {
        "request": forms[True],
        "question": forms[False],
        **{name: spoken for name, spoken in slots.items() if spoken},
        "before": POLITE_BEFORE,
        "after": POLITE_AFTER,
        "other_speech": OTHER_WORDS,
    }
    wake, may_wake = (f"{wake_word} ", f"[{wake_word}] ") if wake_word else ("", "")
    said = "[<before>] <request> [<after>] | <question>" if forms[True] else "<question>"
    # To stop is never wrong, so that the wake word is not waited for.
    stop = f" | {' | '.join(_STOP)}" if wake_word else ""
    lines = [
        "#JSGF V1.0;",
        "grammar mind;",
        f"public <heard> = <said>{stop} | {may_wake}(<other_speech>)+;",
        f"<said> = {wake}({said});",
        *(f"<{name}> = {' | '.join(each)};" for name, each in rules.items() if each),
    ]
    return "\n".join(lines) + "\n"
