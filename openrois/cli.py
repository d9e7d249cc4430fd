"""The `openrois` command. A sub-command is an entry point of the package that does its work; none is imported here."""

import sys
from collections.abc import Callable, Sequence
from importlib.metadata import EntryPoint, entry_points

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
        print(f"openrois: there is no command {given[0]!r}\n\n{_usage(commands)}", file=sys.stderr)
        return 2
    run: Callable[[Sequence[str]], int] = commands[given[0]].load()
    return run(given[1:])


def _usage(commands: dict[str, EntryPoint]) -> str:
    names = "\n".join(f"  openrois {name}" for name in sorted(commands))
    return f"usage: openrois COMMAND [--help] ...\n\n{names}\n  openrois --version"


if __name__ == "__main__":
    raise SystemExit(main())
