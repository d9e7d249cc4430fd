"""The options of a language model and of the limits."""

import argparse
from datetime import date
from pathlib import Path

import pytest
from openrois_agents.mind.limits import CONVERSATION
from openrois_agents.mind.model import options
from openrois_agents.mind.model.chat import ModelSettings
from openrois_agents.mind.model.options import (
    add_limit_options,
    add_model_options,
    budget_choice,
    model_arguments,
    model_choice,
)


def parse(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_model_options(parser)
    add_limit_options(parser)
    return parser.parse_args(arguments)


def test_without_a_server_there_is_no_model() -> None:
    assert model_choice(parse()) is None


def test_a_model_is_its_server_name_and_key() -> None:
    given = ("--llm-url", "https://h.example", "--llm-model", "m", "--llm-key-file", "k", "--llm-sees")
    chosen = model_choice(parse(*given))
    assert isinstance(chosen, ModelSettings)
    assert (chosen.model, chosen.key_file, chosen.sees) == ("m", Path("k"), True)
    assert chosen.url.url("chat/completions") == "https://h.example/v1/chat/completions"
    assert chosen.url.destination == "https://h.example"
    near = model_choice(parse("--llm-url", "http://127.0.0.1:8080/v1/chat/completions", "--llm-model", "m"))
    assert near is not None
    assert (near.url.base, near.url.destination) == ("http://127.0.0.1:8080/v1", "")


@pytest.mark.parametrize(
    ("given", "mistake"),
    [
        (("--llm-model", "m"), "--llm-model is for a language model; name its server with --llm-url"),
        (("--llm-sees",), "--llm-sees is for a language model"),
        (("--llm-url", "http://127.0.0.1:1"), "--llm-url needs --llm-model: name a model that the server has"),
        (("--llm-url", "ftp://h", "--llm-model", "m"), "--llm-url: 'ftp://h' is no address of a server"),
        (("--llm-url", "https://me:secret@h.example", "--llm-model", "m"), "--llm-url: credentials do not belong"),
        (("--llm-url", "http://192.168.1.2:80", "--llm-model", "m"), "or allow it with --llm-unencrypted"),
    ],
)
def test_a_contradiction_is_told_with_its_remedy(given: tuple[str, ...], mistake: str) -> None:
    with pytest.raises(ValueError, match=mistake) as refused:
        model_choice(parse(*given))
    assert "secret" not in str(refused.value)


def test_another_machine_is_spoken_to_without_tls_where_that_is_allowed() -> None:
    chosen = model_choice(parse("--llm-url", "http://192.168.1.2:80", "--llm-model", "m", "--llm-unencrypted"))
    assert chosen is not None
    assert chosen.url.destination == "http://192.168.1.2:80"


def test_what_is_not_installed_is_named_with_the_command_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(options, "missing_modules", lambda _extra: ("aiohttp",))
    with pytest.raises(ValueError, match=r"aiohttp is not installed: run `pip install 'openrois\[speech\]'`"):
        model_choice(parse("--llm-url", "http://127.0.0.1:1", "--llm-model", "m"))


def test_limits_are_of_a_conversation_and_of_a_day() -> None:
    budget = budget_choice(parse("--limit-turns", "2,3", "--limit-tokens", "50"))
    budget.count_turn()
    assert (budget.refusal(), budget.tokens_left) == ("", 50)
    budget.count_turn()
    assert "talked for a long time" in budget.refusal()
    budget.begin_conversation()
    budget.count_turn()
    assert "come back tomorrow" in budget.refusal()
    assert budget_choice(parse()).tokens_left == CONVERSATION.tokens


@pytest.mark.parametrize("text", ["0", "1,0", "-1", "x", "1,", ",1", "1,2,3", "9" * 12, "9" * 5_000, "1.5"])
def test_a_limit_is_one_or_two_numbers(text: str) -> None:
    with pytest.raises(argparse.ArgumentError, match="one or two numbers"):
        parse(f"--limit-turns={text}")


def test_the_use_of_the_day_is_kept_in_the_file(tmp_path: Path) -> None:
    given = ("--use-file", str(tmp_path / "use.json"), "--limit-turns", "9,1")
    budget_choice(parse(*given)).count_turn()
    assert date.today().isoformat() in (tmp_path / "use.json").read_text()
    assert "come back tomorrow" in budget_choice(parse(*given)).refusal()
    with pytest.raises(ValueError, match=r"there is no folder .*; make it first"):
        budget_choice(parse("--use-file", str(tmp_path / "none" / "use.json")))


def test_options_go_to_another_command_line_as_they_were_given() -> None:
    given = ("--llm-url", "https://h", "--llm-model", "m", "--llm-key-file", "k", "--llm-sees", "--limit-turns", "2,3")
    again = model_arguments(parse(*given))
    assert again[:7] == list(given[:7])
    assert parse(*again) == parse(*given)
    assert parse(*model_arguments(parse())) == parse()
