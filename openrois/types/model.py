"""What every model of the wire has in common."""

from pydantic import BaseModel, ConfigDict

__all__ = ["Model"]


class Model(BaseModel):
    """A frozen value; unknown fields are refused, and text, numbers and truth values are never converted silently."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)
