"""A gateway's settings from options, environment, configuration file and defaults, in this order of precedence."""

import argparse
import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from openrois.auth.key_files import is_exposed
from openrois.cli.command_line import CommandLine, suggestion
from openrois.gateway.settings import GROUPS, GatewaySettings

__all__ = ["Configured", "Setting", "configure", "printed", "settings_of"]

PREFIX: Final = "OPENROIS_GATEWAY_"
"""Of the environment's variables: `OPENROIS_GATEWAY_PORT`."""

_CONFIG: Final = f"{PREFIX}CONFIG"
_WARNING: Final = "{} can be read by others on this machine; chmod 600 keeps the secret"
_LARGEST: Final = 1 << 20
"""Bytes of a configuration file or of a secret."""


@dataclass(frozen=True, slots=True)
class Setting:
    """One setting, and its name in each place.

    Attributes:
        table: its table of the configuration file.
        field: its field of `GatewaySettings`.
        info: its default and meaning.
    """

    table: str
    field: str
    info: FieldInfo

    @property
    def is_secret(self) -> bool:
        """Whether it comes from a file of its own."""
        return bool(self._extra["secret"])

    @property
    def is_list(self) -> bool:
        """Whether it has any number of values."""
        return isinstance(self.info.default, tuple)

    @property
    def is_path(self) -> bool:
        """Whether its value is a file's name; of a secret it is."""
        return self.is_secret or self.info.annotation is Path or Path in get_args(self.info.annotation)

    @property
    def key(self) -> str:
        """Its key in its table."""
        return f"{self.field}_file" if self.is_secret else self.field

    @property
    def variable(self) -> str:
        """Its environment variable; several values are separated by commas there."""
        return PREFIX + self.key.upper()

    @property
    def option(self) -> str:
        """Its option; a setting with several values is given several times."""
        name = self.key.removesuffix("s") if self.is_list else self.key
        return "--" + name.replace("_", "-")

    @property
    def metavar(self) -> str:
        """Its value's placeholder in the help."""
        return "FILE" if self.is_secret else str(self._extra["metavar"]) or self.key.upper()

    @property
    def meaning(self) -> str:
        """Its line in the help."""
        return f"holds {self.info.description}" if self.is_secret else str(self.info.description)

    @property
    def _extra(self) -> dict[str, Any]:
        extra = self.info.json_schema_extra
        return extra if isinstance(extra, dict) else {"metavar": "", "secret": False}


@dataclass(frozen=True, slots=True)
class Configured:
    """Settings as they were found.

    Attributes:
        settings: all of them, secrets included.
        sources: of those that are set, where: an option, a variable, or a file.
        given: of those that are set, the value as it was given; of a secret the name of its file.
        warnings: sentences for the operator, to be logged once the log is set up.
        print_only: they are to be shown, and nothing is to be run.
        migrates_back: the store is to be carried back by one version, and nothing is to be run.
    """

    settings: GatewaySettings
    sources: Mapping[str, str]
    given: Mapping[str, Any]
    warnings: tuple[str, ...]
    print_only: bool
    migrates_back: bool


def settings_of() -> tuple[Setting, ...]:
    """Return every setting, in the order of the configuration file."""
    return tuple(Setting(group.table, name, info) for group in GROUPS for name, info in group.model_fields.items())


def configure(arguments: Sequence[str], environment: Mapping[str, str]) -> Configured:
    """Read options, environment and configuration file.

    Raises:
        ValueError: what is wrong, and where it was given.
        SystemExit: an option is unknown, or help was asked for.
    """
    options = vars(_parser().parse_args(arguments))
    found: dict[str, tuple[Any, str]] = {}
    file = options.pop("config") or environment.get(_CONFIG)
    if file:
        found |= _from_text(_text(Path(file)), Path(file))
    found |= _from_environment(environment)
    print_only, migrates_back = options.pop("print_config"), options.pop("migrate_store_back")
    known = {setting.field: setting for setting in settings_of()}
    found |= {name: (value, known[name].option) for name, value in options.items() if value is not None}
    values = {}
    for name, (value, source) in found.items():
        values[name] = _secret(value, source) if known[name].is_secret else value
    sources = {name: source for name, (_, source) in found.items()}
    try:
        settings = GatewaySettings(**values)
    except ValidationError as error:
        raise ValueError("; ".join(_problems(error, sources))) from None
    given = {name: value for name, (value, _) in found.items()}
    files = [str(value) for name, value in given.items() if known[name].is_secret]
    warnings = tuple(_WARNING.format(file) for file in files if is_exposed(Path(file)))
    return Configured(settings, sources, given, warnings, print_only, migrates_back)


def printed(configured: Configured) -> str:
    """Return the settings as a configuration file with the source of each; secrets are left out."""
    lines: list[str] = []
    table = ""
    for setting in settings_of():
        if setting.table != table:
            table = setting.table
            lines += ["", f"[{table}]"]
        given = configured.given.get(setting.field) if setting.is_secret else None
        value = given if setting.is_secret else getattr(configured.settings, setting.field)
        source = configured.sources.get(setting.field, "default")
        lines.append(f"# {setting.meaning} ({source})")
        lines.append(f"# {setting.key} is not set" if value is None else f"{setting.key} = {_toml(value)}")
    return "\n".join(lines[1:]) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(_toml(each) for each in value) + "]"
    if isinstance(value, Path):
        value = str(value)
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _parser() -> argparse.ArgumentParser:
    parser = CommandLine(
        "openrois gateway",
        description="The main HRI engine, on one port. Options win over the environment, and that over the file.",
    )
    parser.add_argument("--config", metavar="FILE", help=f"settings as TOML ({_CONFIG})")
    parser.add_argument("--print-config", action="store_true", help="show the settings and where each came from")
    parser.add_argument(
        "--migrate-store-back",
        action="store_true",
        help="carry the tables of the store back to the version before, and start nothing",
    )
    for setting in settings_of():
        default = setting.info.default
        shown = "" if setting.is_secret or default in (None, (), False, True) else f" ({default})"
        text = f"{setting.meaning}{shown}".replace("%", "%%")
        if setting.info.annotation is bool:
            parser.add_argument(
                setting.option, dest=setting.field, action=argparse.BooleanOptionalAction, default=None, help=text
            )
        elif setting.is_list:
            parser.add_argument(
                setting.option,
                dest=setting.field,
                action="append",
                metavar=setting.metavar,
                help=f"{text} (repeatable)",
            )
        else:
            parser.add_argument(setting.option, dest=setting.field, metavar=setting.metavar, help=text)
    return parser


def _from_environment(environment: Mapping[str, str]) -> Iterator[tuple[str, tuple[Any, str]]]:
    known = {setting.variable: setting for setting in settings_of()}
    for variable in sorted(environment):
        if not variable.startswith(PREFIX) or variable == _CONFIG:
            continue
        setting = known.get(variable)
        if setting is None:
            raise ValueError(f"{variable} is no setting{suggestion(variable, known)}")
        text = environment[variable]
        value = tuple(filter(None, (part.strip() for part in text.split(",")))) if setting.is_list else text
        yield setting.field, (value, variable)


def _from_text(text: str, path: Path) -> Iterator[tuple[str, tuple[Any, str]]]:
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path} is no TOML: {error}") from None
    known = {group.table: {s.key: s for s in settings_of() if s.table == group.table} for group in GROUPS}
    for table, entries in content.items():
        if table not in known or not isinstance(entries, dict):
            raise ValueError(f"{path}: [{table[:80]}] is no table of settings{suggestion(table, known)}")
        for key, value in entries.items():
            setting = known[table].get(key)
            if setting is None:
                raise ValueError(f"{path}: [{table}] {key[:80]} is no setting{_hint(table, key, known)}")
            if setting.is_path:
                value = _beside(path, value)
            yield setting.field, (value, f"{path}: [{table}] {key}")


def _beside(path: Path, value: Any) -> Any:
    """Return names of files relative to the file that names them."""
    if isinstance(value, list):
        return [_beside(path, each) for each in value]
    return str(path.parent / value) if isinstance(value, str) else value


def _hint(table: str, key: str, known: Mapping[str, Mapping[str, Setting]]) -> str:
    if f"{key}_file" in known[table]:
        return f"; a secret is in a file of its own, which {key}_file names"
    for other, settings in known.items():
        if key in settings:
            return f" there; it belongs to [{other}]"
    return suggestion(key, known[table])


def _text(path: Path) -> str:
    """Return the content of a file.

    Raises:
        ValueError: it cannot be read, is no text, or is too long.
    """
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise ValueError(f"{path} cannot be read: it is too long")
        return content.decode()
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path} cannot be read: it is no text") from None


def _secret(file: Any, source: str) -> str:
    """Return the first line of the file. Raises ValueError."""
    if not isinstance(file, str):
        raise ValueError(f"{source}: the name of the file that holds a secret is a text")
    try:
        text = _text(Path(file))
    except ValueError as error:
        raise ValueError(f"{source}: the secret in {error}") from None
    return text.partition("\n")[0].strip()


def _problems(error: ValidationError, sources: Mapping[str, str]) -> Iterator[str]:
    for entry in error.errors(include_url=False, include_context=False, include_input=False):
        message = entry["msg"].removeprefix("Value error, ")
        if not entry["loc"]:
            yield message
            continue
        name = str(entry["loc"][0])
        yield f"{sources.get(name, name)}: {message}"
