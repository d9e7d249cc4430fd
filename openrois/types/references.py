"""References and ids: `<engine_id>/<rest>`, from the adapter to the application, never rewritten on the way."""

import secrets
from typing import Final

__all__ = ["engine_of", "flaw_of_name", "new_id", "reference"]

MAX_ID: Final = 128
"""Characters of an engine's id, or of a component's name."""


def flaw_of_name(text: str) -> str:
    """Return why `text` cannot name an engine, or a component of one; empty where it can."""
    if not text:
        return "it is empty"
    if len(text) > MAX_ID:
        return f"it has more than {MAX_ID} characters"
    if "/" in text:
        return "it has a slash"
    # It stands in logs and on screens: a line break or a change of direction would make it look like something else.
    return "" if text.isprintable() else "it has a character that cannot be printed"


def engine_of(reference: str) -> str:
    """Return the engine id that leads `reference`; empty where nothing leads it."""
    head, slash, _ = reference.partition("/")
    return head if slash else ""


def reference(engine_id: str, name: str) -> str:
    """Return the component_ref of component `name` of engine `engine_id`."""
    return f"{engine_id}/{name}"


def new_id(engine_id: str) -> str:
    """Return an id of engine `engine_id`: its own id and 128 random bits, so that it can't be guessed."""
    return f"{engine_id}/{secrets.token_hex(16)}"
