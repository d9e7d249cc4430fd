"""What is wrong with a command's arguments is one line, and a slip is answered with what was meant."""

import pytest

from openrois.cli.command_line import CommandLine, suggestion


def parser() -> CommandLine:
    made = CommandLine("lamp", description="A lamp.")
    made.add_argument("--brightness", type=int)
    parts = made.add_subparsers(dest="part")
    parts.add_parser("blink").add_argument("--times", type=int)
    return made


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--brigthness=3", "lamp: --brigthness=3 is not known here; is it --brightness? (`lamp --help`"),
        ("--bright=3", "lamp: --bright=3 is not known here; is it --brightness? ("),
        ("--colour=red", "lamp: --colour=red is not known here ("),
        ("--brightness full", "lamp: argument --brightness: invalid int value: 'full' ("),
        ("blink --time 3", "lamp blink: --time is not known here; is it --times? (`lamp blink --help`"),
        ("blink now", "lamp blink: now is not known here ("),
    ],
)
def test_wrong_usage_is_one_line(arguments: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        parser().parse_args(arguments.split())
    shown = capsys.readouterr().err
    assert ended.value.code == 2
    assert shown.startswith(said)
    assert shown.endswith("` says what there is)\n")
    assert shown.count("\n") == 1


def test_what_is_right_is_read() -> None:
    assert parser().parse_args(["--brightness", "3"]).brightness == 3
    assert parser().parse_args(["blink", "--times", "2"]).times == 2


def test_a_suggestion_is_similar_or_none() -> None:
    assert suggestion("gatewy", ["avatar", "gateway"]) == "; is it gateway?"
    assert suggestion("dance", ["avatar", "gateway"]) == ""
