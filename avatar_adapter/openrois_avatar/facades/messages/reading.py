"""Reading the signaling messages of game engines: JSON objects with a `type`, of bounded size. Pure."""

import json
from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, Generic, TypeVar

from openrois_signaling.messages import CANDIDATE_LIMIT, MID_LIMIT, SDP_LIMIT
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.alias_generators import to_camel

__all__ = [
    "MESSAGE_LIMIT",
    "CandidateText",
    "Mid",
    "Name",
    "Part",
    "ProtocolError",
    "Reason",
    "Said",
    "Sdp",
    "Unknown",
    "Vocabulary",
]

MESSAGE_LIMIT: Final = 128 * 1024
"""Bytes of one message; a description grows in JSON, where each end of a line takes four bytes."""

NAME_LIMIT: Final = 256
"""Characters of an id or name."""

REASON_LIMIT: Final = 1024
"""Characters of a text for people."""

Name = Annotated[str, Field(min_length=1, max_length=NAME_LIMIT)]
Sdp = Annotated[str, Field(min_length=1, max_length=SDP_LIMIT)]
CandidateText = Annotated[str, Field(max_length=CANDIDATE_LIMIT)]
Mid = Annotated[str, Field(max_length=MID_LIMIT)]
Reason = Annotated[str, Field(max_length=REASON_LIMIT)]


class ProtocolError(Exception):
    """A malformed message of a game engine; the text says what is wrong, without parts of the message."""


class Part(BaseModel):
    """An object of a foreign protocol: immutable, members in camel case; members of later versions are ignored."""

    model_config = ConfigDict(frozen=True, strict=True, extra="ignore", alias_generator=to_camel, populate_by_name=True)


class Said(Part):
    """A message of a foreign protocol; `type` is its name there."""

    type: ClassVar[str]

    def text(self) -> str:
        """Return the message as JSON, without absent members."""
        return json.dumps({"type": self.type, **self.model_dump(mode="json", by_alias=True, exclude_none=True)})


@dataclass(frozen=True, slots=True)
class Unknown:
    """A message of an unknown type, which is no fault: protocols grow."""

    type: str


class _Typed(BaseModel):
    model_config = ConfigDict(strict=True, extra="ignore")
    type: Annotated[str, Field(min_length=1, max_length=NAME_LIMIT)]


MessageT = TypeVar("MessageT", bound=Said)


class Vocabulary(Generic[MessageT]):
    """The messages of one end of a protocol, by their type.

    Args:
        messages: their classes.
    """

    def __init__(self, *messages: type[MessageT]) -> None:
        self._readers = {message.type: message for message in messages}

    def read(self, text: str) -> MessageT | Unknown:
        """Read one message.

        Raises:
            ProtocolError: it is too long, no JSON object with a type, or has a wrong member.
        """
        if len(text) > MESSAGE_LIMIT:
            raise ProtocolError(f"a message has more than {MESSAGE_LIMIT} characters, which is the limit")
        try:
            name = _Typed.model_validate_json(text).type
        except ValidationError as error:
            raise ProtocolError(f"no message with a type: {_first(error)}") from error
        reader = self._readers.get(name)
        if reader is None:
            return Unknown(name)
        try:
            return reader.model_validate_json(text)
        except ValidationError as error:
            raise ProtocolError(f"{name}: {_first(error)}") from error


def _first(error: ValidationError) -> str:
    """Return the first error, without the input."""
    found = error.errors(include_input=False, include_url=False, include_context=False)[0]
    place = ".".join(str(part) for part in found["loc"])
    return f"{place}: {found['msg']}" if place else found["msg"]
