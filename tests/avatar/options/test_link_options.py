import argparse
from pathlib import Path

import pytest
from openrois_avatar.options.link_options import add_facade_option, add_link_options, link_arguments, link_secret
from openrois_avatar.options.settings import DEFAULT_LINK


def parse(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_link_options(parser)
    add_facade_option(parser)
    return parser.parse_args(arguments)


def test_without_options_any_engine_of_this_machine_will_do() -> None:
    chosen = parse()
    assert (chosen.link, link_secret(chosen)) == (DEFAULT_LINK, "")
    assert parse(*link_arguments(chosen)) == chosen


def test_options_can_be_passed_on(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("s3cret\n")
    chosen = parse("--link", "unix:/run/avatar", "--link-secret-file", str(tmp_path / "secret"))
    assert (chosen.link, link_secret(chosen)) == ("unix:/run/avatar", "s3cret")
    assert parse(*link_arguments(chosen)) == chosen


def test_a_facade_is_awaited_on_this_machine(capsys: pytest.CaptureFixture[str]) -> None:
    chosen = parse("--facade", "[::1]:9000")
    assert parse(*link_arguments(chosen)).facade == "[::1]:9000"
    with pytest.raises(SystemExit):
        parse("--facade", "0.0.0.0:8888")
    assert "this machine only" in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"", b" \n", b"x" * 201, b"\xff", None])
def test_a_file_without_a_secret_is_named(tmp_path: Path, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "secret").write_bytes(content)
    with pytest.raises(ValueError, match="--link-secret-file"):
        link_secret(parse("--link-secret-file", str(tmp_path / "secret")))
