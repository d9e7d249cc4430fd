"""Conditions: a subset of CQL2-Text. Empty for everything, or comparisons joined by AND. Pure.

A comparison is `property = 'text'` or `property LIKE 'pattern'`; a quote inside the text is doubled. In a pattern `%`
stands for any text, `_` for one character, and a backslash takes either as it is. Keywords may be in any case; a
property may stand in double quotes. Parsing and matching take time linear in the condition (times the text, for LIKE).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final

from openrois.errors import BadParameter

__all__ = ["Comparison", "Condition", "parse_condition"]

MAX_LENGTH: Final = 4096

KEPT: Final = 1024
"""Conditions in the cache, of all applications."""

KEPT_LENGTH: Final = 256
"""Characters of a condition that is cached."""

_PARTS: Final = 4
"""Parts of a pattern by which few of many texts can be chosen."""

# Every repetition is possessive (`*+`), so that nothing is ever read twice.
_TOKEN: Final = re.compile(
    r"\s*+(?:(?P<name>[A-Za-z_:][A-Za-z0-9_.:]*+)"
    r'|"(?P<quoted>[A-Za-z_:][A-Za-z0-9_.:]*+)"'
    r"|'(?P<text>[^']*+(?:''[^']*+)*+)'"
    r"|(?P<equals>=)"
    r"|(?P<end>$))"
)


@dataclass(frozen=True, slots=True)
class Comparison:
    """One comparison of a property with a text or a pattern.

    Attributes:
        property: its name.
        pattern: whether `text` is a pattern.
        text: what is compared with.
        prefix: how every text begins that satisfies it.
        parts: texts without a slash that stand in every text which satisfies it, some of them.
    """

    property: str
    pattern: bool
    text: str
    prefix: str = field(init=False, repr=False, compare=False)
    parts: tuple[str, ...] = field(init=False, repr=False, compare=False)
    _like: re.Pattern[str] | None = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        literals = _literals(self.text) if self.pattern else [self.text]
        object.__setattr__(self, "prefix", literals[0])
        parts = {part for literal in literals for part in literal.split("/")}
        object.__setattr__(self, "parts", tuple(sorted(parts - {""}, key=len, reverse=True)[:_PARTS]))
        object.__setattr__(self, "_like", _compiled(self.text) if self.pattern else None)

    def matches(self, value: str) -> bool:
        """Tell whether `value` satisfies it."""
        return value == self.text if self._like is None else self._like.fullmatch(value) is not None


@dataclass(frozen=True, slots=True)
class Condition:
    """Comparisons that must all hold; with none, everything matches."""

    comparisons: tuple[Comparison, ...] = ()

    def matches(self, properties: Mapping[str, str]) -> bool:
        """Tell whether every comparison holds; a property that is absent satisfies none."""
        return all(c.property in properties and c.matches(properties[c.property]) for c in self.comparisons)

    def value_of(self, name: str) -> str | None:
        """Return the text that property `name` must equal, or None where the condition does not say."""
        return next((c.text for c in self.comparisons if c.property == name and not c.pattern), None)

    def without(self, *names: str) -> "Condition":
        """Return the condition without the comparisons of the properties `names`."""
        return Condition(tuple(c for c in self.comparisons if c.property not in names))


def parse_condition(text: str, properties: frozenset[str]) -> Condition:
    """Read a condition.

    Args:
        text: the condition.
        properties: the properties that may be named.

    Raises:
        BadParameter: it cannot be read, is longer than 4096 characters, or names another property.
    """
    if len(text) > MAX_LENGTH:
        raise BadParameter(f"a condition has at most {MAX_LENGTH} characters")
    return _parse_kept(text, properties) if len(text) <= KEPT_LENGTH else _parse(text, properties)


def _parse(text: str, properties: frozenset[str]) -> Condition:
    tokens = _Tokens(text)
    comparisons: list[Comparison] = []
    if tokens.kind != "end":
        comparisons.append(_comparison(tokens, properties))
        while tokens.is_keyword("AND"):
            tokens.advance()
            comparisons.append(_comparison(tokens, properties))
    if tokens.kind != "end":
        raise BadParameter(f"the condition goes on where it should end, at character {tokens.position}")
    return Condition(tuple(comparisons))


# Applications ask for the same few components all the time. What cannot be read is not kept.
_parse_kept: Final = lru_cache(maxsize=KEPT)(_parse)


class _Tokens:
    """A cursor over the tokens of a condition; `kind` and `value` are the token under it."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._end = 0
        self.advance()

    def advance(self) -> None:
        match = _TOKEN.match(self._text, self._end)
        if match is None or match.lastgroup is None:
            raise BadParameter(f"the condition cannot be read at character {self._end}")
        self.kind, self.value = match.lastgroup, match[match.lastgroup]
        self.position, self._end = match.start(match.lastgroup), match.end()

    def is_keyword(self, keyword: str) -> bool:
        return self.kind == "name" and self.value.upper() == keyword


def _comparison(tokens: _Tokens, properties: frozenset[str]) -> Comparison:
    if tokens.kind not in ("name", "quoted"):
        raise BadParameter(f"a property is expected at character {tokens.position} of the condition")
    name = tokens.value
    if name not in properties:
        raise BadParameter(f"a condition cannot ask for {name!r} here; it can ask for {', '.join(sorted(properties))}")
    tokens.advance()
    pattern = tokens.is_keyword("LIKE")
    if not pattern and tokens.kind != "equals":
        raise BadParameter(f"= or LIKE is expected at character {tokens.position} of the condition")
    tokens.advance()
    if tokens.kind != "text":
        raise BadParameter(f"a text in quotes is expected at character {tokens.position} of the condition")
    text = tokens.value.replace("''", "'")
    tokens.advance()
    return Comparison(name, pattern, text)


def _compiled(pattern: str) -> re.Pattern[str]:
    """Return what matches whole texts as LIKE does: what a `%` has taken, up to the next text, it does not give back.

    It is made once for a condition; walking through each pattern again and again, for each component, took a whole
    gateway's time.
    """
    parts: list[str] = [""]
    for item in _pattern_items(pattern):
        if item == "%":
            parts.append("")
        else:
            parts[-1] += "." if item == "_" else re.escape(item[1:])
    first, *more = parts
    middle = "".join(f"(?>.*?{part})" for part in more[:-1] if part)
    return re.compile(first + middle + (f".*{more[-1]}" if more else ""), re.DOTALL)


def _literals(pattern: str) -> list[str]:
    """Return the texts before, between and behind the wildcards of a pattern."""
    literals = [""]
    for item in _pattern_items(pattern):
        if item in ("%", "_"):
            literals.append("")
        else:
            literals[-1] += item[1:]
    return literals


def _pattern_items(pattern: str) -> list[str]:
    """Split a pattern into `%`, `_`, and literal characters, each marked by a backslash."""
    items: list[str] = []
    escaped = False
    for character in pattern:
        if escaped or character not in "%_\\":
            items.append("\\" + character)
            escaped = False
        elif character == "\\":
            escaped = True
        else:
            items.append(character)
    if escaped:
        items.append("\\\\")
    return items
