"""The answer of a tool, whatever protocol carries it. Pure."""

from dataclasses import dataclass, field
from typing import Any

__all__ = ["Answer"]


@dataclass(frozen=True, slots=True)
class Answer:
    """What a tool answers.

    Attributes:
        text: for a language model.
        data: the same for a program.
        picture: a JPEG file; empty where there is none.
    """

    text: str
    data: dict[str, Any] = field(default_factory=dict)
    picture: bytes = b""
