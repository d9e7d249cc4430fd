"""Messages that are wrong in known ways, and what has to be answered: told by the damage, not by any reader. Pure."""

import json
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from openrois.schema import openrpc

if TYPE_CHECKING:
    from tests.support.corpus import Case

__all__ = ["LONGEST", "Malformed", "malformed"]

LONGEST: Final = 60_000
"""Characters of a message; the gateway takes 64 KiB."""

_TEXTS: Final = ("", "x", "日本", "\\", '"', "a\nb", "null", "1", "🤖")
_NUMBERS: Final = 1_000_000_000
_NO_IDS: Final[tuple[Any, ...]] = ({}, [], ["c"], True, False, {"id": 1})
_NO_ENVELOPES: Final = ("[]", "5", '"rois.system.connect"', "true", "null", "[[]]", "-0.5")
_BREAKS: Final[tuple[Callable[[str], str], ...]] = (
    lambda text: text[:-1],
    lambda text: text[: len(text) // 2],
    lambda text: text + text,
    lambda text: text + "]",
    lambda text: text.replace('"', "'"),
    lambda text: text.replace(":", "=", 1),
    lambda text: text[:-1] + ",}",
    lambda text: text[:-1] + ',"n":NaN}',
    lambda text: text[:-1] + ',"n":-Infinity}',
    lambda text: text[:-1] + ',"n":01}',
    lambda text: text[:-1] + ',"n":"\t"}',
    lambda text: text[:-1] + ',"n":"\\x"}',
    lambda text: text[:-1] + ',"n":' + "9" * 5000 + "}",
    lambda text: text[:-1] + ',"n":' + "[" * 20_000 + "}",
    lambda text: "/* */" + text,
    lambda _text: "",
)
_MISNAMES: Final[tuple[Callable[[str], str], ...]] = (
    lambda name: name + " ",
    lambda name: name.upper(),
    lambda name: name + ".__init__",
    lambda name: name.replace(".", "/"),
    lambda name: name.replace(".", "\u2024"),
    lambda name: name + "\u200b",
    lambda name: name + "\x00",
    lambda name: name.rpartition(".")[2],
    lambda _name: "__class__",
    lambda _name: "",
    lambda name: name * 100,
)
_ENVELOPES: Final[tuple[dict[str, Any], ...]] = (
    {"jsonrpc": "1.0"},
    {"jsonrpc": 2.0},
    {"jsonrpc": None},
    {"method": 5},
    {"method": None},
    {"method": ["rois.system.connect"]},
)


@dataclass(frozen=True, slots=True)
class Malformed:
    """A message that is wrong.

    Attributes:
        text: it.
        answered_as: the id that its error has to have.
        code: of that error.
    """

    text: str
    answered_as: int | str | None
    code: int


def malformed(seed: int) -> Iterator[Malformed]:
    """Yield messages without end; no two with an id of their own have the same one."""
    dice = random.Random(seed)
    wrong = _misfits()
    names = sorted({name for name, _ in wrong})
    makers = (_broken, _enveloped, _unknown, _misfit, _misfit)
    number = 0
    while True:
        number += 1
        answered_as: int | str = number if dice.random() < 0.5 else f"{dice.choice(_TEXTS)}{_NUMBERS + number}"
        made = dice.choice(makers)(dice, answered_as, names, wrong)
        if len(made.text.encode()) <= LONGEST:
            yield made


def _misfits() -> list[tuple[str, Any]]:
    """Return every method with all params of the corpus that do not fit it."""
    from tests.support.corpus import corpus  # a wheel has no tests

    found = []
    for method in json.loads(openrpc())["methods"]:
        name = method["name"]
        cases = corpus()[method["x-params"]["$ref"].rpartition("/")[2]]
        found += [(name, case.message) for case in cases if _is_misfit(name, case)]
        found += [(name, params) for params in ([], [1], "x", 5, True, {"no_such_param": 1})]
    return found


def _is_misfit(method: str, case: "Case") -> bool:
    # What is only too long for signaling is refused with a return code, and a null stands for no params.
    too_long = method.startswith("signaling.") and case.name.endswith("too long")
    return not case.is_valid and case.kind != "rule" and not too_long and case.message is not None


def _request(answered_as: int | str, method: str, params: Any) -> dict[str, Any]:
    return {"jsonrpc": "2.0", "id": answered_as, "method": method, "params": params}


def _broken(dice: random.Random, answered_as: int | str, names: list[str], wrong: list[tuple[str, Any]]) -> Malformed:
    text = json.dumps(_request(answered_as, dice.choice(names), {}))
    return Malformed(dice.choice(_BREAKS)(text), None, -32700)


def _enveloped(
    dice: random.Random, answered_as: int | str, names: list[str], wrong: list[tuple[str, Any]]
) -> Malformed:
    message = _request(answered_as, dice.choice(names), {})
    kind = dice.randrange(4)
    if kind == 0:
        text = dice.choice((*_NO_ENVELOPES, json.dumps([message])))
        return Malformed(text, None, -32600)
    if kind == 1:
        return Malformed(json.dumps(message | {"id": dice.choice(_NO_IDS)}), None, -32600)
    if kind == 2:
        del message[dice.choice(("jsonrpc", "method"))]
        return Malformed(json.dumps(message), answered_as, -32600)
    return Malformed(json.dumps(message | dice.choice(_ENVELOPES)), answered_as, -32600)


def _unknown(dice: random.Random, answered_as: int | str, names: list[str], wrong: list[tuple[str, Any]]) -> Malformed:
    misnamed = dice.choice(_MISNAMES)(dice.choice(names))
    params = dice.choice(({}, [1], None, {"component_ref": "bench/gauge"}))
    return Malformed(json.dumps(_request(answered_as, misnamed, params)), answered_as, -32601)


def _misfit(dice: random.Random, answered_as: int | str, names: list[str], wrong: list[tuple[str, Any]]) -> Malformed:
    name, params = dice.choice(wrong)
    return Malformed(json.dumps(_request(answered_as, name, params)), answered_as, -32602)
