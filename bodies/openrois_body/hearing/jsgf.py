"""Grammars in JSGF: read, checked, written in plain form, and matched against sentences. Pure.

A recogniser never gets the text of an application, but the grammar that was read from it. Not supported are imports,
recursion and the special rules <NULL> and <VOID>; tags are read and dropped. A rule <other_speech> has words that catch
speech that is no sentence: the recogniser needs them, and what they match is no sentence of the grammar.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

__all__ = ["MAX_GRAMMAR", "MAX_TOKENS", "Grammar", "GrammarError", "chosen_grammar", "read_grammar"]

MAX_GRAMMAR: Final = 16_384
"""Characters of a grammar."""

MAX_TOKENS: Final = 2000
"""Words of a rule with all its references written out: what is longer would take a recogniser too long."""
_DEEPEST: Final = 10
"""Parentheses within parentheses, and rules within rules."""
_HEADER: Final = re.compile(r"\ufeff?#JSGF\s+V\d+\.\d+[^;\n]{0,80};")
_TOKEN: Final = re.compile(
    r"\s+|//[^\n]*|/\*.*?\*/|(?P<tag>\{[^{}]*\})|(?P<rule><[^<>\s]+>)|(?P<weight>/\s*[\d.]+\s*/)"
    r'|"(?P<quoted>[^=|()\[\]*+;<>{}"/\n]*)"|(?P<sign>[=|()\[\]*+;])|(?P<word>[^\s=|()\[\]*+;<>{}"/]+)',
    re.DOTALL,
)
_OTHER_SPEECH: Final = "other_speech"
_RULE_NAME: Final = re.compile(r"<[\w.-]{1,64}>")


class GrammarError(ValueError):
    """The grammar cannot be used; the text says why."""


@dataclass(frozen=True, slots=True)
class _Word:
    text: str


@dataclass(frozen=True, slots=True)
class _Reference:
    rule: str


@dataclass(frozen=True, slots=True)
class _Repeated:
    """`optional`: it can be left out; `many`: it can come again."""

    part: _Part
    optional: bool
    many: bool


@dataclass(frozen=True, slots=True)
class _Sequence:
    parts: tuple[_Part, ...]


@dataclass(frozen=True, slots=True)
class _Choice:
    """`weights` are there for all alternatives or for none."""

    parts: tuple[_Part, ...]
    weights: tuple[float, ...]


_Part = _Word | _Reference | _Repeated | _Sequence | _Choice


class Grammar:
    """A checked grammar: no rule refers to a missing rule, or to itself."""

    def __init__(self, rules: Mapping[str, _Part], public: tuple[str, ...]) -> None:
        self._rules = rules
        self.public = public
        """The names of the public rules, without brackets."""

    def rule(self, name: str) -> str:
        """Return the rule of a name: the first public one for `default`.

        Raises:
            GrammarError: there is no such public rule.
        """
        if name == "default":
            return self.public[0]
        wanted = name.strip("<>").lower()
        if wanted not in self.public:
            raise GrammarError(f"the grammar has no public rule {name!r}; it has {', '.join(self.public)}")
        return wanted

    def words(self, rule: str) -> frozenset[str]:
        """Return all words of the rule."""
        return frozenset(_words(self._rules[rule], self._rules))

    def has_other_speech(self, rule: str) -> bool:
        """Return whether the rule has words for speech that is none of its sentences."""
        return _is_used(_OTHER_SPEECH, (rule,), self._rules)

    def text(self, rule: str) -> str:
        """Return the grammar as JSGF, with this rule as its only public one."""
        lines = ["#JSGF V1.0;", "grammar heard;"]
        lines += [
            f"{'public ' if name == rule else ''}<{name}> = {_written(part)};" for name, part in self._rules.items()
        ]
        return "\n".join(lines) + "\n"

    def accepts(self, rule: str, sentence: str) -> bool:
        """Return whether the rule accepts `sentence`, words with blanks between, without words for other speech."""
        said = _Said(tuple(sentence.split()), self._rules)
        return len(said.words) in said.after(self._rules[rule], 0)

    def begins(self, rule: str, words: str) -> bool:
        """Return whether a sentence that the rule accepts begins with these words, or is them."""
        said = _Said(tuple(words.split()), self._rules)
        return len(said.words) in said.after(self._rules[rule], 0) or said.goes_on


class _Said:
    """A match of a sentence with parts of a grammar, computed once for each part and place.

    `goes_on`: a part of the grammar was looked for behind all words of the sentence.
    """

    def __init__(self, words: tuple[str, ...], rules: Mapping[str, _Part]) -> None:
        self.words = words
        self.goes_on = False
        self._rules = rules
        self._known: dict[tuple[int, int], frozenset[int]] = {}

    def after(self, part: _Part, at: int) -> frozenset[int]:
        """Return the places in the sentence where `part` can end if it begins at the place `at`."""
        key = id(part), at
        if key not in self._known:
            self._known[key] = self._reached(part, at)
        return self._known[key]

    def _reached(self, part: _Part, at: int) -> frozenset[int]:
        match part:
            case _Word(text):
                self.goes_on |= at == len(self.words)
                return frozenset({at + 1} if self.words[at : at + 1] == (text,) else ())
            case _Reference(name):
                return frozenset() if name == _OTHER_SPEECH else self.after(self._rules[name], at)
            case _Sequence(parts):
                places = frozenset({at})
                for each in parts:
                    places = self._from(places, each)
                return places
            case _Choice(parts, _):
                return frozenset().union(*(self.after(each, at) for each in parts))
        reached = self.after(part.part, at)
        while part.many and not (further := self._from(reached, part.part)) <= reached:
            reached |= further
        return reached | {at} if part.optional else reached

    def _from(self, places: frozenset[int], part: _Part) -> frozenset[int]:
        return frozenset().union(*(self.after(part, at) for at in places))


def chosen_grammar(grammar: str, rule: str) -> tuple[Grammar | None, str]:
    """Return the grammar and the name of its rule that an application has set; None for open dictation.

    Raises:
        GrammarError: the grammar or rule does not exist, or is not supported.
    """
    if grammar in ("default", ""):
        if rule not in ("default", ""):
            raise GrammarError("the grammar `default` is open dictation; its only rule is `default`")
        return None, ""
    if not grammar.lstrip("\ufeff").startswith("#JSGF"):
        raise GrammarError("the grammar must be `default` or a text in JSGF that begins with `#JSGF V1.0;`")
    if len(grammar) > MAX_GRAMMAR:
        raise GrammarError(f"the grammar has {len(grammar)} characters, and at most {MAX_GRAMMAR} are allowed")
    read = read_grammar(grammar)
    return read, read.rule(rule or "default")


def read_grammar(text: str) -> Grammar:
    """Read a grammar, in lower case.

    Raises:
        GrammarError: the text is no JSGF, or not supported; the text says why.
    """
    header = _HEADER.match(text)
    if header is None:
        raise GrammarError("the grammar has no header; its first line has to be `#JSGF V1.0;`")
    reader = _Reader(_tokens(text[header.end() :].lower()))
    rules, public = reader.rules()
    if not public:
        raise GrammarError("the grammar has no public rule; write `public` before one")
    for name in public:
        _check(name, rules)
    return Grammar({name: part for name, part in rules.items() if _is_used(name, public, rules)}, public)


def _tokens(text: str) -> list[tuple[str, str]]:
    """Return kind and text of each token."""
    found: list[tuple[str, str]] = []
    place = 0
    while place < len(text):
        token = _TOKEN.match(text, place)
        if token is None:
            raise GrammarError(f"the grammar has an unexpected character at {text[place : place + 20]!r}")
        if token.lastgroup is not None:
            found.append((token.lastgroup, token[token.lastgroup]))
        place = token.end()
    return [*found, ("end", "")]


class _Reader:
    """Reads a grammar from its tokens, from left to right."""

    def __init__(self, tokens: list[tuple[str, str]]) -> None:
        self._tokens = tokens
        self._at = 0
        self._depth = 0

    def rules(self) -> tuple[dict[str, _Part], tuple[str, ...]]:
        """Return all rules by name, and the names of the public ones."""
        self._expect("word", "grammar")
        self._next_token()
        self._expect("sign", ";")
        rules: dict[str, _Part] = {}
        public: list[str] = []
        while self._next[0] != "end":
            is_public = self._next == ("word", "public")
            if is_public:
                self._next_token()
            name = self._rule_name()
            if name in rules:
                raise GrammarError(f"the rule <{name}> is defined twice; rename one")
            self._expect("sign", "=")
            rules[name] = self._choice()
            self._expect("sign", ";")
            if is_public:
                public.append(name)
        return rules, tuple(public)

    @property
    def _next(self) -> tuple[str, str]:
        return self._tokens[self._at]

    def _next_token(self) -> tuple[str, str]:
        token = self._next
        self._at = min(self._at + 1, len(self._tokens) - 1)
        return token

    def _expect(self, kind: str, text: str) -> None:
        found = self._next_token()
        if found != (kind, text):
            raise GrammarError(f"the grammar has {found[1] or 'its end'!r} where {text!r} is expected")

    def _rule_name(self) -> str:
        kind, text = self._next_token()
        if kind != "rule":
            raise GrammarError(f"the grammar has {text or 'its end'!r} where a rule like <name> is expected")
        if not _RULE_NAME.fullmatch(text) or text in {"<null>", "<void>"}:
            raise GrammarError(f"the rule name {text} is not supported; use letters, digits, `_`, `.` and `-`")
        return text.strip("<>")

    def _choice(self) -> _Part:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise GrammarError(f"parentheses may be nested {_DEEPEST} deep at most")
        weights, parts = [self._weight()], [self._sequence()]
        while self._next == ("sign", "|"):
            self._next_token()
            weights.append(self._weight())
            parts.append(self._sequence())
        self._depth -= 1
        given = tuple(weight for weight in weights if weight is not None)
        if given and len(given) < len(parts):
            raise GrammarError("only some alternatives have a weight; give one to all of them or to none")
        return parts[0] if len(parts) == 1 else _Choice(tuple(parts), given)

    def _weight(self) -> float | None:
        if self._next[0] != "weight":
            return None
        _, text = self._next_token()
        try:
            weight = float(text.strip("/ \t\n"))
        except ValueError:
            raise GrammarError(f"{text} is no weight; write a number, as /0.5/") from None
        if not 0 < weight <= 1000:
            raise GrammarError(f"a weight must be above 0 and at most 1000, not {text}")
        return weight

    def _sequence(self) -> _Part:
        parts: list[_Part] = []
        while (part := self._item()) is not None:
            parts.append(part)
        if not parts:
            raise GrammarError(f"a word or rule is missing in the grammar before {self._next[1] or 'its end'!r}")
        return parts[0] if len(parts) == 1 else _Sequence(tuple(parts))

    def _item(self) -> _Part | None:
        kind, text = self._next
        part: _Part
        if kind == "rule":
            part = _Reference(self._rule_name())
        elif kind == "word" or (kind == "quoted" and text.strip()):
            self._next_token()
            words = tuple(_Word(each) for each in text.split())
            part = words[0] if len(words) == 1 else _Sequence(words)
        elif (kind, text) == ("sign", "("):
            part = self._enclosed(")")
        elif (kind, text) == ("sign", "["):
            part = _Repeated(self._enclosed("]"), optional=True, many=False)
        else:
            return None
        while self._next in {("sign", "*"), ("sign", "+")}:
            part = _repeated(part, optional=self._next_token()[1] == "*")
        while self._next[0] == "tag":
            self._next_token()
        return part

    def _enclosed(self, closing: str) -> _Part:
        self._next_token()
        inner = self._choice()
        self._expect("sign", closing)
        return inner


def _repeated(part: _Part, *, optional: bool) -> _Part:
    """Return `part` repeated; a repetition is not wrapped again."""
    if isinstance(part, _Repeated):
        return _Repeated(part.part, optional=optional or part.optional, many=True)
    return _Repeated(part, optional=optional, many=True)


def _inner(part: _Part) -> tuple[_Part, ...]:
    match part:
        case _Sequence(parts) | _Choice(parts, _):
            return parts
        case _Repeated(inner, _, _):
            return (inner,)
    return ()


def _references(part: _Part) -> Iterable[str]:
    if isinstance(part, _Reference):
        yield part.rule
    for each in _inner(part):
        yield from _references(each)


def _check(name: str, rules: Mapping[str, _Part]) -> None:
    """Refuse missing and recursive rules, and a rule that is too long when it is written out."""
    sizes: dict[str, int] = {}

    def size(part: _Part, within: tuple[str, ...]) -> int:
        if isinstance(part, _Reference):
            return size_of(part.rule, within)
        return isinstance(part, _Word) + sum(size(each, within) for each in _inner(part))

    def size_of(rule: str, within: tuple[str, ...]) -> int:
        if rule in within:
            raise GrammarError(f"the rule <{rule}> refers to itself; recursion is not supported")
        if rule not in rules:
            raise GrammarError(f"the grammar refers to the rule <{rule}>, which it does not define")
        if len(within) >= _DEEPEST:
            raise GrammarError(f"rules may refer to each other {_DEEPEST} deep at most")
        if rule not in sizes:
            sizes[rule] = size(rules[rule], (*within, rule))
        return sizes[rule]

    if (tokens := size_of(name, ())) > MAX_TOKENS:
        raise GrammarError(
            f"the rule <{name}> has {tokens} words when it is written out, and at most {MAX_TOKENS} are allowed"
        )


def _is_used(name: str, public: Iterable[str], rules: Mapping[str, _Part]) -> bool:
    found, open_ = set(public), list(public)
    while open_:
        new = set(_references(rules[open_.pop()])) - found
        found |= new
        open_ += new
    return name in found


def _words(part: _Part, rules: Mapping[str, _Part]) -> Iterable[str]:
    if isinstance(part, _Word):
        yield part.text
    elif isinstance(part, _Reference):
        yield from _words(rules[part.rule], rules)
    for each in _inner(part):
        yield from _words(each, rules)


def _written(part: _Part) -> str:
    match part:
        case _Word(text):
            return text
        case _Reference(rule):
            return f"<{rule}>"
        case _Repeated(inner, optional, many):
            return f"({_written(inner)}){'*' if optional else '+'}" if many else f"[{_written(inner)}]"
        case _Sequence(parts):
            return " ".join(_written(each) for each in parts)
    marks = [f"/{weight:g}/ " for weight in part.weights] or [""] * len(part.parts)
    return f"({' | '.join(mark + _written(each) for mark, each in zip(marks, part.parts, strict=True))})"
