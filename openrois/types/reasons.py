"""Reasons of refusals and failures: the notification that stands before the code, and the sentence in it."""

from typing import Annotated, ClassVar, Final

from pydantic import Field

from openrois.types.model import Model

__all__ = ["MAX_REASON", "ReasonNotification", "sentence"]

MAX_REASON: Final = 500
"""Characters of a reason."""

_READ: Final = 4 * MAX_REASON


class ReasonNotification(Model):
    """Params of the notification `openrois.reason`: why the message right behind it says something else than OK.

    That message is the reply to the request `request_id`, or the `completed` of the command `command_id`; the other
    of the two is left out.
    """

    method: ClassVar[str] = "openrois.reason"

    request_id: str | int | float | None = None
    command_id: str | None = None
    reason: Annotated[str, Field(min_length=1, max_length=MAX_REASON)]


def sentence(told: object) -> str:
    """Return a text of the other side as one line of at most `MAX_REASON` characters; empty where there is none."""
    text = str(told)[:_READ]
    if not text.isprintable():
        text = "".join(character if character.isprintable() else " " for character in text)
    line = " ".join(text.split())
    return line if len(line) <= MAX_REASON else f"{line[: MAX_REASON - 1]}…"
