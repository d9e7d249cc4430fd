"""Common base of every model of the wire."""

from typing import Any, Final, Self

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler
from pydantic_core import CoreSchema

__all__ = ["PASSING_OVER", "Model"]

PASSING_OVER: Final = {"passes_over": True}
"""The context of a reading that passes over members which this version does not know."""


def _stop_at_first_flaw(schema: Any) -> None:
    if isinstance(schema, list | tuple):
        for each in schema:
            _stop_at_first_flaw(each)
    elif isinstance(schema, dict):
        if schema.get("type") in ("tuple", "list"):
            schema["fail_fast"] = True
        for each in schema.values():
            _stop_at_first_flaw(each)


class Model(BaseModel):
    """A frozen value; unknown fields are refused, and text, numbers and truth values are never converted silently.

    Of a list only the first item that does not fit is reported: one long message with all takes half a second.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    @classmethod
    def read_newer(cls, said: Any) -> Self:
        """Read what a program that may be newer says: members that this version does not know are passed over.

        Results and notifications are read so; what is in requests is done as it is said, or refused.

        Raises:
            ValidationError: it does not fit.
        """
        # Not by `model_validate`: events are read here, of which there are many.
        read: Self = cls.__pydantic_validator__.validate_python(said, extra="ignore", context=PASSING_OVER)
        return read

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of the model, with lists that are read up to their first flaw."""
        schema = handler(source)
        _stop_at_first_flaw(schema)
        return schema
