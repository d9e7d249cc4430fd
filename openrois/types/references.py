"""References and ids: `<engine_id>/<rest>`, from the adapter to the application, never rewritten on the way."""

import secrets
from typing import Final

__all__ = ["engine_of", "is_engine_id", "new_id", "reference"]


MAX_ID: Final = 128
"""Characters of an engine's id, or of a component's name."""


def is_engine_id(text: str) -> bool:
    """Tell whether `text` can name an engine: not empty, without a slash, at most `MAX_ID` characters."""
    return 0 < len(text) <= MAX_ID and "/" not in text


def engine_of(reference: str) -> str:
    """Return the engine id that leads `reference`; empty where nothing leads it."""
    head, slash, _ = reference.partition("/")
    return head if slash else ""


def reference(engine_id: str, name: str) -> str:
    """Return the component_ref of component `name` of engine `engine_id`."""
    return f"{engine_id}/{name}"


def new_id(engine_id: str) -> str:
    """Return an id that engine `engine_id` mints: its own id and 128 random bits, so that it can't be guessed."""
    return f"{engine_id}/{secrets.token_hex(16)}"
