"""A group of settings: a table of the configuration file whose keys are options and variables too."""

from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field

__all__ = ["SettingsGroup", "require_between", "setting"]


def setting(default: Any, meaning: str, *, metavar: str = "", secret: bool = False) -> Any:
    """Return a field that becomes a key of the configuration file, a variable of the environment and an option.

    Args:
        default: what holds unless it is set.
        meaning: one line for people, without a full stop.
        metavar: what stands for the value in the help.
        secret: it comes only from a file, which `<name>_file` names, and is never shown.
    """
    extra: dict[str, Any] = {"metavar": metavar, "secret": secret}
    return Field(default, description=meaning, repr=not secret, json_schema_extra=extra)


class SettingsGroup(BaseModel):
    """Settings that belong together: a table of the configuration file.

    Attributes:
        table: its name there.
    """

    # What was refused may be a secret.
    model_config = ConfigDict(frozen=True, extra="forbid", hide_input_in_errors=True, allow_inf_nan=False)

    table: ClassVar[str] = ""

    def secrets(self) -> tuple[str, ...]:
        """Return the secrets themselves, so that a log can leave them out."""
        fields = type(self).model_fields.items()
        extra = {name: info.json_schema_extra for name, info in fields if isinstance(info.json_schema_extra, dict)}
        return tuple(str(getattr(self, name)) for name, known in extra.items() if known.get("secret"))


def require_between(option: str, value: float, least: float, most: float, unit: str = "") -> None:
    """Do nothing where a value is between two bounds, these included.

    Raises:
        ValueError: it is not; the message names the option, the bounds and the value.
    """
    if not least <= value <= most:
        raise ValueError(f"{option} must be between {least:g} and {most:g}{unit and f' {unit}'}, not {value:g}")
