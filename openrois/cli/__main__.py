"""The `openrois` command. A sub-command is an entry point of the package that does its work; none is imported here."""

import ast
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path

from openrois.cli.command_line import suggestion
from openrois.extras import name_missing_extra
from openrois.version import __version__

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `openrois COMMAND ...` and return its exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    commands = {entry.name: entry for entry in entry_points(group="openrois.commands")}
    if given[:1] == ["--version"]:
        print(f"openrois {__version__}")
        return 0
    if not given or given[0] in ("-h", "--help"):
        print(_usage(commands))
        return 0
    if given[0] not in commands:
        close = suggestion(given[0], commands)
        print(f"openrois: there is no command {given[0]!r}{close} (`openrois --help` lists them)", file=sys.stderr)
        return 2
    try:
        run: Callable[[Sequence[str]], int] = commands[given[0]].load()
        return run(given[1:])
    except ModuleNotFoundError as error:
        sentence = name_missing_extra(error, given[0])
        if sentence is None:
            raise
        print(f"openrois {given[0]}: {sentence}", file=sys.stderr)
        return 1


def _usage(commands: dict[str, EntryPoint]) -> str:
    width = max(len(name) for name in commands) if commands else 0
    lines = [f"  {name:{width}}  {_purpose(commands[name])}".rstrip() for name in sorted(commands)]
    return "\n".join(
        (
            "usage: openrois COMMAND [--help] ...",
            "       openrois --version",
            "",
            "RoIS 2.0 for robots and virtual avatars.",
            "",
            *lines,
            "",
            "openrois COMMAND --help says more.",
        )
    )


def _purpose(entry: EntryPoint) -> str:
    """Return the first line of a command's module, which is read but not run: importing them all takes seconds."""
    try:
        spec = find_spec(entry.module)
        source = Path(spec.origin or "").read_text(encoding="utf-8") if spec is not None else ""
        said = (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]
    except (ImportError, OSError, SyntaxError, ValueError):
        return ""
    called, _, purpose = said.partition(": ")
    return purpose.rstrip(".") if called == f"`openrois {entry.name}`" else ""


if __name__ == "__main__":
    raise SystemExit(main())
