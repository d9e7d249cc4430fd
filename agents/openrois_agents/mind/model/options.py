"""The options of a language model and of what conversations may use."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Final

from openrois_body.services.address import read_address

from openrois.cli.command_line import given_options
from openrois.extras import install_command, missing_modules
from openrois_agents.mind.limits import CONVERSATION, DAY, Budget, Limits
from openrois_agents.mind.model.chat import PATH, ModelSettings
from openrois_agents.mind.use_file import UseFile

__all__ = ["add_limit_options", "add_model_options", "budget_choice", "model_arguments", "model_choice"]

_MOST: Final = 1_000_000_000
_CLIENT: Final = "aiohttp"
_EXTRA: Final = "speech"
"""What brings the client of servers."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """A limit of a conversation and of a day."""

    conversation: int
    day: int

    def __str__(self) -> str:
        return f"{self.conversation},{self.day}"


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add `--llm-url` and the options that belong to it."""
    group = parser.add_argument_group(
        "language model", "a server with an API like OpenAI's, which answers visitors; without it rules answer them"
    )
    group.add_argument(
        "--llm-url", metavar="URL", help="of a server with /v1/chat/completions, as http://127.0.0.1:8080/v1"
    )
    group.add_argument("--llm-model", default="", metavar="NAME", help="that answers at the server")
    group.add_argument(
        "--llm-key-file", type=Path, metavar="FILE", help="holds the key for the server in its first line"
    )
    group.add_argument(
        "--llm-sees", action="store_true", help="the model reads pictures: it may look through the body's camera"
    )
    group.add_argument(
        "--llm-unencrypted",
        action="store_true",
        help="a server of another machine may be spoken to over http://, where it can be read on the way",
    )


def add_limit_options(parser: argparse.ArgumentParser) -> None:
    """Add the limits of conversations."""
    group = parser.add_argument_group(
        "limits", "what one conversation and, behind a comma, one day may use; the visitor is told politely"
    )
    for name, what in (("turns", "answers"), ("tokens", "tokens of a language model"), ("sound", "seconds of speech")):
        usual = _Pair(round(getattr(CONVERSATION, name)), round(getattr(DAY, name)))
        group.add_argument(f"--limit-{name}", type=_pair, default=usual, metavar="N,N", help=f"{what} (%(default)s)")
    group.add_argument(
        "--use-file",
        type=Path,
        metavar="FILE",
        help="keeps what the day has used over restarts; in memory unless it is given",
    )


def model_choice(chosen_options: argparse.Namespace) -> ModelSettings | None:
    """Return the language model that the options name; None where they name none.

    Raises:
        ValueError: they contradict each other; a sentence for a person.
    """
    options = chosen_options
    if options.llm_url is None:
        others = ("llm_model", "llm_key_file", "llm_sees", "llm_unencrypted")
        if given := [f"--{name.replace('_', '-')}" for name in others if getattr(options, name)]:
            raise ValueError(f"{given[0]} is for a language model; name its server with --llm-url")
        return None
    if not options.llm_model:
        raise ValueError("--llm-url needs --llm-model: name a model that the server has")
    try:
        url = read_address(options.llm_url, PATH, unencrypted=options.llm_unencrypted, allowed_by="--llm-unencrypted")
    except ValueError as error:
        raise ValueError(f"--llm-url: {error}") from None
    if _CLIENT in missing_modules(_EXTRA):
        raise ValueError(f"--llm-url: {_CLIENT} is not installed: run `{install_command(_EXTRA)}`")
    return ModelSettings(url, options.llm_model, options.llm_key_file, options.llm_sees)


def budget_choice(chosen_options: argparse.Namespace) -> Budget:
    """Return the limits that the options say, with what the day has used so far.

    Raises:
        ValueError: the folder of the file for it is not there; a sentence for a person.
    """
    options = chosen_options
    pairs = (options.limit_turns, options.limit_tokens, options.limit_sound)
    conversation = Limits(*(each.conversation for each in pairs))
    day = Limits(*(each.day for each in pairs))
    if options.use_file is None:
        return Budget(conversation, day, date.today)
    if not options.use_file.absolute().parent.is_dir():
        raise ValueError(f"--use-file: there is no folder {options.use_file.absolute().parent}; make it first")
    file = UseFile(options.use_file)
    return Budget(conversation, day, date.today, file.read(), file.write)


def model_arguments(chosen_options: argparse.Namespace) -> Sequence[str]:
    """Return the options of the model and the limits, for another command line."""
    model = ("llm_url", "llm_model", "llm_key_file", "llm_sees", "llm_unencrypted")
    return given_options(chosen_options, *model, "limit_turns", "limit_tokens", "limit_sound", "use_file")


def _pair(text: str) -> _Pair:
    """Read `N` or `N,N`."""
    first, comma, second = text.partition(",")
    for each in (first, second) if comma else (first,):
        if not (each.isascii() and each.isdigit() and 0 < int(each[:12]) <= _MOST):
            raise argparse.ArgumentTypeError(f"must be one or two numbers from 1 on, as 40,1000, not {text[:40]}")
    return _Pair(int(first), int(second) if comma else _MOST)
