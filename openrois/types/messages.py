"""Params and results of the operations and notifications of the base wire, one model each.

A method's params are named as the IDL's `in` parameters, its result as `return_code` and the `out` parameters. A
failure in RoIS terms is a result whose `return_code` is not OK and whose other fields have their defaults.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, Self

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, ValidationError, ValidationInfo

from openrois.types.codes import CompletedStatus, ErrorType, ReturnCode
from openrois.types.model import PASSING_OVER, Model
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile

__all__ = [
    "Argument",
    "CommandResultParams",
    "CommandUnit",
    "Completed",
    "ComponentParams",
    "ConcurrentCommands",
    "ConditionParams",
    "DetailParams",
    "ErrorDetailParams",
    "ErrorNotification",
    "EventNotification",
    "ExecuteParams",
    "NoParams",
    "Parameter",
    "ParametersResult",
    "ProfileResult",
    "QueryParams",
    "ReferenceResult",
    "Result",
    "ResultsResult",
    "ReturnResult",
    "SearchResult",
    "SequenceItem",
    "SetParameterParams",
    "SetParameterResult",
    "SubscribeParams",
    "SubscribeResult",
    "UnsubscribeParams",
]

MAX_DELAY: Final = 86_400_000
"""Milliseconds of a delay: a day."""

MAX_ITEMS: Final = 256
"""Items of a command unit sequence."""

Code = Annotated[ReturnCode, Field(strict=False)]


class Result(Model):
    """A named value with its type; `value` is always text, see `openrois.types.values`."""

    name: str
    data_type_ref: str
    value: str


class Parameter(Result):
    """A parameter of a component."""


class Argument(Result):
    """An argument of a command."""


class CommandUnit(Model):
    """One command. `delay_time` is the milliseconds between its turn and its start."""

    component_ref: str
    command_type: str
    command_id: str
    arguments: tuple[Argument, ...] = Field(default=(), strict=False)
    delay_time: Annotated[int, Field(ge=0, le=MAX_DELAY)] | None = None


class ConcurrentCommands(Model):
    """Commands that run at the same time; the next item of the sequence waits for all of them."""

    command_list: tuple[CommandUnit, ...] = Field(strict=False)
    delay_time: Annotated[int, Field(ge=0, le=MAX_DELAY)] | None = None


def _read_item(item: Any) -> CommandUnit | ConcurrentCommands:
    """Read `item` with the one model it is meant for, so that a misfit is named by its path in the params alone."""
    if isinstance(item, CommandUnit | ConcurrentCommands):
        return item
    concurrent = isinstance(item, dict) and "command_list" in item
    return (ConcurrentCommands if concurrent else CommandUnit).model_validate(item)


def _not_empty(items: tuple[Any, ...]) -> tuple[Any, ...]:
    if not items:
        raise ValueError("there is no command in the sequence")
    return items


def _up_to_a_flaw(profiles: Any, info: ValidationInfo) -> Any:
    """Return profiles by their references; where one does not fit that one alone, so that one error is reported."""
    if not isinstance(profiles, dict):
        return profiles
    extra: Literal["ignore"] | None = "ignore" if info.context is PASSING_OVER else None
    read = {}
    for ref, profile in profiles.items():
        try:
            read[ref] = HRIComponentProfile.model_validate(profile, extra=extra)
        except ValidationError:
            return {ref: profile}
    return read


SequenceItem = Annotated[CommandUnit | ConcurrentCommands, BeforeValidator(_read_item)]


class NoParams(Model):
    """No params."""


class ConditionParams(Model):
    """Params of get_profile, search and bind_any: a condition, empty for everything."""

    condition: str = ""


class ComponentParams(Model):
    """Params of bind, release and get_parameter."""

    component_ref: str


class SetParameterParams(Model):
    """Params of set_parameter: several parameters are one change."""

    component_ref: str
    parameters: tuple[Parameter, ...] = Field(strict=False)


class ExecuteParams(Model):
    """Params of execute: a command unit sequence of at least one item."""

    command_unit_list: Annotated[
        tuple[SequenceItem, ...],
        Field(max_length=MAX_ITEMS, strict=False, json_schema_extra={"minItems": 1}),
        AfterValidator(_not_empty),
    ]


class CommandResultParams(Model):
    """Params of get_command_result."""

    command_id: str
    condition: str = ""


class QueryParams(Model):
    """Params of query."""

    query_type: str
    condition: str = ""


class SubscribeParams(Model):
    """Params of subscribe."""

    event_type: str
    condition: str = ""


class UnsubscribeParams(Model):
    """Params of unsubscribe."""

    subscribe_id: str


class DetailParams(Model):
    """Params of get_event_detail."""

    event_id: str
    condition: str = ""


class ErrorDetailParams(Model):
    """Params of get_error_detail."""

    error_id: str
    condition: str = ""


class ReturnResult(Model):
    """A result without out parameters. On the wire its return code always stands."""

    model_config = ConfigDict(json_schema_extra={"required": ["return_code"]})

    return_code: Code = ReturnCode.OK

    @classmethod
    def read(cls, result: Any) -> Self:
        """Read a result off the wire; members that this version does not know are passed over.

        Raises:
            ValidationError: it does not fit, or has no return code.
        """
        if isinstance(result, Mapping) and "return_code" not in result:
            result = {**result, "return_code": None}
        return cls.read_newer(result)


class ProfileResult(ReturnResult):
    """Result of get_profile; `component_profiles` is an extension of the wire."""

    profile: HRIEngineProfile | None = None
    component_profiles: Annotated[dict[str, HRIComponentProfile], BeforeValidator(_up_to_a_flaw)] = Field(
        default_factory=dict
    )


class SearchResult(ReturnResult):
    """Result of search."""

    component_ref_list: tuple[str, ...] = Field(default=(), strict=False)


class ReferenceResult(ReturnResult):
    """Result of bind_any."""

    component_ref: str = ""


class ParametersResult(ReturnResult):
    """Result of get_parameter."""

    parameters: tuple[Parameter, ...] = Field(default=(), strict=False)


class SetParameterResult(ReturnResult):
    """Result of set_parameter; the outcome comes as `completed` with this id."""

    command_id: str = ""


class ResultsResult(ReturnResult):
    """Result of query, get_command_result, get_event_detail and get_error_detail."""

    results: tuple[Result, ...] = Field(default=(), strict=False)


class SubscribeResult(ReturnResult):
    """Result of subscribe."""

    subscribe_id: str = ""


class Completed(Model):
    """Notification: a command has ended, sent exactly once."""

    command_id: str
    status: Annotated[CompletedStatus, Field(strict=False)]


class EventNotification(Model):
    """Notification: an event happened. `results` is an extension that repeats what get_event_detail gives."""

    event_id: str
    event_type: str
    subscribe_id: str
    expire: str = ""
    results: tuple[Result, ...] = Field(default=(), strict=False)


class ErrorNotification(Model):
    """Notification: an engine or a component reports a fault; get_error_detail tells more."""

    error_id: str
    error_type: Annotated[ErrorType, Field(strict=False)]
