"""Arguments of a command; a mistake is answered in one line, with the option that was probably meant."""

import argparse
import difflib
from collections.abc import Iterable, Sequence
from typing import Any, Final, NoReturn

__all__ = ["CommandLine", "given_options", "port_number", "suggestion"]

_WRONG_USAGE: Final = 2


class CommandLine(argparse.ArgumentParser):
    """An `argparse.ArgumentParser` that takes no abbreviations, and answers a mistake in one line."""

    def __init__(self, prog: str | None, **more: Any) -> None:
        super().__init__(prog, allow_abbrev=False, **more)

    def error(self, message: str) -> NoReturn:
        """End the program with status 2, and one line with the mistake and where to read more."""
        self.exit(_WRONG_USAGE, f"{self.prog}: {message} (`{self.prog} --help` says what there is)\n")

    def parse_known_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """Parse arguments; the parser of a sub-command also refuses an unknown option here."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            known = [option for action in self._actions for option in action.option_strings]
            self.error(f"{unknown[0]} is not known here{suggestion(unknown[0].partition('=')[0], known)}")
        return found, unknown


def given_options(chosen_options: argparse.Namespace, *names: str) -> Sequence[str]:
    """Return those of the named options that were given, for the command line of another program."""
    found: list[str] = []
    for name in names:
        value, option = getattr(chosen_options, name), f"--{name.replace('_', '-')}"
        if value is True:
            found.append(option)
        elif value:
            found += (option, str(value))
    return found


def port_number(text: str) -> int:
    """Read the number of a TCP port, as the `type` of an argument.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    if not (text.isascii() and text.isdigit() and 0 < int(text) < 1 << 16):
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a port from 1 to 65535")
    return int(text)


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return a question to add to an error: whether the most similar of the known names is meant; or nothing."""
    close = difflib.get_close_matches(name, known, n=1)
    return f"; is it {close[0]}?" if close else ""
