"""The words of the house: one verb one meaning, and sentences that name their subject."""

import ast
import re
from collections import Counter, defaultdict
from functools import cache
from pathlib import Path
from typing import Final

from tests.support.packages import ROOT, modules, tracked

MOST_CLASSES: Final = 25
INTERFACE_VERBS: Final = {
    "add": "puts one more into what holds many",
    "close": "ends what holds a resource",
    "from_json": "reads a message of the engine link",
    "open": "begins what `close` ends",
    "run": "does the work of an object until it is cancelled or done",
    "send": "hands a message over to the other side",
    "start": "begins what `stop` ends (RoIS_Common)",
    "stop": "ends what `start` of a component has begun (RoIS_Common)",
    "to_json": "writes a message of the engine link",
}
"""Method names that many classes share, and what each means in all of them."""

VAGUE_VERBS: Final = ("take", "tell", "look", "answer", "end", "forget")
"""Verbs that say nothing without an object."""
MEANT: Final = {
    # The answer to an offer, which is public, and to a visitor.
    "answer": {"MeasuringSink", "Mind", "ModelMind", "PlainSink", "RuleMind"},
    "forget": {"Enrolment", "Mind", "ModelMind", "RuleMind"},  # a command on the wire; a conversation
    "look": {"Gaze"},  # a command on the wire
    "take": {"Control", "LeaseKeeper", "LeaseModel", "_Leases"},  # `openrois.lease.take`
}
"""Classes in which such a verb is a name of the wire, or of the field."""
RIDDLES: Final = re.compile(r"\b(nobody|somebody|whoever)\b", re.IGNORECASE)
MOST_RIDDLES: Final = 20
TEXTS: Final = {".py", ".ts", ".md", ".toml", ".html", ".cs", ".gd", ".sh", ".service"}


@cache
def classes_of_methods() -> dict[str, set[str]]:
    """Return, for each method name of the packages, the classes that define it."""
    found: dict[str, set[str]] = defaultdict(set)
    for path in modules():
        for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                methods = (each for each in node.body if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef))
                for method in (each for each in methods if not is_property(each)):
                    found[method.name].add(f"{path}:{node.name}")
    return found


def is_property(method: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Tell whether it is read like an attribute, and so is no verb."""
    return any(ast.unparse(each) in {"property", "cached_property"} for each in method.decorator_list)


def riddles() -> Counter[str]:
    """Return how often each tracked text leaves its subject open."""
    paths = (path for path in tracked() if Path(path).suffix in TEXTS and ROOT / path != Path(__file__))
    found = {path: len(RIDDLES.findall((ROOT / path).read_text(encoding="utf-8"))) for path in paths}
    return Counter({path: count for path, count in found.items() if count})


def test_a_method_name_is_shared_by_few_classes_or_is_the_verb_of_an_interface() -> None:
    shared = {name: len(classes) for name, classes in classes_of_methods().items() if len(classes) > MOST_CLASSES}
    assert {name for name in shared if not name.startswith("__")} <= set(INTERFACE_VERBS), shared


def test_a_verb_that_says_little_has_an_object() -> None:
    found = classes_of_methods()
    named = {verb: {each.rpartition(":")[2] for each in found.get(verb, ())} for verb in VAGUE_VERBS}
    assert not {f"{each}.{verb}" for verb, classes in named.items() for each in classes - MEANT.get(verb, set())}


def test_sentences_name_their_subject() -> None:
    found = riddles()
    assert found.total() <= MOST_RIDDLES, found.most_common()
