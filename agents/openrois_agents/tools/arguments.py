"""The arguments of each tool, checked before anything is asked of a body. Pure."""

from typing import Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from openrois.errors import BadParameter

__all__ = [
    "KINDS",
    "Arguments",
    "AskVisitor",
    "Call",
    "Gesture",
    "GoTo",
    "Listen",
    "Look",
    "LookAt",
    "Nothing",
    "Say",
    "Stop",
    "UseBody",
    "WaitForEvent",
    "Where",
    "read_arguments",
]

Name = Annotated[str, Field(min_length=1, max_length=200)]
Text = Annotated[str, Field(min_length=1, max_length=4_000)]
Share = Annotated[float, Field(ge=-1, le=1)]
Metres = Annotated[float, Field(ge=-10_000, le=10_000)]
Body = Annotated[Name | None, Field(description="which body; the one that is held, or the only one, unless given")]


class Arguments(BaseModel):
    """Arguments of a tool; unknown ones are mistakes."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class Nothing(Arguments):
    """A tool without arguments."""


class UseBody(Arguments):
    """Arguments of `use_body`."""

    body: Annotated[Name | None, Field(description="which body; whichever is free unless given")] = None
    tools: Annotated[
        list[Literal["say", "gesture", "look_at", "go_to", "call"]] | None,
        Field(
            min_length=1,
            max_length=5,
            description="what this task may do with it, and nothing else; go_to and call have to be named",
        ),
    ] = None
    wait: Annotated[float, Field(ge=0, le=60, description="seconds to wait for a body that is taken")] = 5.0


class Say(Arguments):
    """Arguments of `say`."""

    text: Annotated[Text, Field(description="what to say")]
    language: Annotated[str | None, Field(pattern="^[a-z]{2}$", description="ISO 639-1 code")] = None
    volume: Annotated[int | None, Field(ge=0, le=100)] = None


class Gesture(Arguments):
    """Arguments of `gesture`."""

    name: Annotated[Name, Field(description="which gesture")]


class GoTo(Arguments):
    """Arguments of `go_to`."""

    place: Annotated[Name | None, Field(description="a place by its name; or give x and y")] = None
    x: Annotated[Metres | None, Field(description="metres on the body's floor")] = None
    y: Annotated[Metres | None, Field(description="metres on the body's floor")] = None
    facing: Annotated[float | None, Field(ge=-7, le=7, description="radians; any direction unless given")] = None
    seconds: Annotated[float, Field(gt=0, le=600, description="that it may take; then the body stands")] = 60.0

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.place is None) == (self.x is None or self.y is None) or (self.x is None) != (self.y is None):
            raise ValueError("give a place, or x and y")
        if self.place is not None and self.facing is not None:
            raise ValueError("facing goes with x and y")
        return self


class LookAt(Arguments):
    """Arguments of `look_at`."""

    direction: Annotated[Literal["ahead", "left", "right", "up", "down"] | None, Field(description="as seen by it")] = (
        None
    )
    x: Annotated[Share | None, Field(description="-1 is the viewer's left, 1 the viewer's right")] = None
    y: Annotated[Share | None, Field(description="-1 is down, 1 is up")] = None

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.direction is None) == (self.x is None and self.y is None):
            raise ValueError("give a direction, or x and y")
        return self


class Look(Arguments):
    """Arguments of `look`."""

    body: Body = None
    camera: Annotated[Name | None, Field(description="a component_ref, where the body has several cameras")] = None
    width: Annotated[int, Field(ge=64, le=1280, description="pixels of the longer side at most")] = 768


class Where(Arguments):
    """Arguments of `where`."""

    body: Body = None


class Listen(Arguments):
    """Arguments of `listen`."""

    seconds: Annotated[float, Field(gt=0, le=60, description="to wait for words")] = 20.0
    body: Body = None


class AskVisitor(Arguments):
    """Arguments of `ask_visitor`."""

    question: Annotated[Text, Field(description="what to ask")]
    seconds: Annotated[float, Field(gt=0, le=60, description="to wait for words behind the question")] = 20.0


class WaitForEvent(Arguments):
    """Arguments of `wait_for_event`."""

    events: Annotated[
        list[Name], Field(max_length=16, description="which to watch from now on; none: whatever is logged")
    ] = []
    seconds: Annotated[float, Field(ge=0, le=60, description="to wait for the first one")] = 30.0
    after: Annotated[int | None, Field(ge=0, description="only events behind this number; from now unless given")] = (
        None
    )
    body: Body = None


class Stop(Arguments):
    """Arguments of `stop`."""

    body: Body = None


class Call(Arguments):
    """Arguments of `call`."""

    component: Annotated[Name, Field(description="its component_ref, as the profile resource has it")]
    kind: Annotated[
        Literal["query", "command", "get_parameters", "set_parameters"],
        Field(description="query and get_parameters need no body that is held"),
    ]
    name: Annotated[Name | None, Field(description="of the query or command")] = None
    arguments: Annotated[
        dict[str, Any], Field(description="of the command, or the parameters to set, by name", max_length=64)
    ] = {}

    @model_validator(mode="after")
    def _has_a_name(self) -> Self:
        if (self.name is None) == (self.kind in ("query", "command")):
            raise ValueError("query and command need a name, and nothing else takes one")
        return self


KINDS: Final = tuple(Arguments.__subclasses__())
"""The arguments of all tools."""


def read_arguments(tool: str, kind: type[Arguments], given: Any) -> Arguments:
    """Read the arguments of a tool.

    Raises:
        BadParameter: they do not fit; the sentence says each mistake.
    """
    try:
        return kind.model_validate({} if given is None else given)
    except ValidationError as error:
        mistakes = [
            f"{'.'.join(map(str, each['loc'])) or 'arguments'}: {each['msg'].removeprefix('Value error, ')}"
            for each in error.errors(include_url=False, include_input=False)
        ]
        raise BadParameter(f"{tool}: {'; '.join(mistakes[:5])}") from None
