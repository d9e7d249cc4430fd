import argparse

import pytest
from openrois_avatar.options.engine_options import add_engine_options, engine_arguments


def parsed(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_engine_options(parser)
    return parser.parse_args(arguments)


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("--engine", "puppet", "--size", "1280x720", "--visitor"),
        ("--engine", "synthetic", "--stamp"),
        ("--engine", "external"),
    ],
)
def test_options_reach_another_command_line_as_they_are(arguments: tuple[str, ...]) -> None:
    chosen = parsed(*arguments)
    assert parsed(*engine_arguments(chosen)) == chosen


def test_size_and_visitor_are_not_asked_for_by_default() -> None:
    chosen = parsed()
    assert (chosen.size, chosen.visitor) == (None, False)


@pytest.mark.parametrize("engine", ["godot", "external", "unreal", "unity-render-streaming", "synthetic"])
def test_size_and_visitor_are_refused_where_another_program_draws(engine: str) -> None:
    with pytest.raises(
        ValueError, match=rf"^--size cannot be used with --engine {engine}, only with panda3d or puppet$"
    ):
        engine_arguments(parsed("--engine", engine, "--size", "640x360"))
    with pytest.raises(
        ValueError, match=rf"^--visitor cannot be used with --engine {engine}, only with panda3d or puppet$"
    ):
        engine_arguments(parsed("--engine", engine, "--visitor"))
