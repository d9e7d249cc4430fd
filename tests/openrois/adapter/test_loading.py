"""Components that are named on a command line."""

import argparse
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from openrois.adapter import Component, command
from openrois.adapter.loading import add_component_option, load_components, make_components
from openrois.component.component import Component as Base
from openrois.errors import BadParameter

SOURCE = """
from openrois.adapter import Component, command

class Lamp(Component, authority="Example", function="actuation"):
    pass

class Greeter(Component, authority="Example", function="actuation"):
    def __init__(self, body):
        super().__init__()
        self.body = body

class Renamed(Lamp):
    def __init__(self):
        super().__init__("second_lamp")

class Demanding(Component, authority="Example", function="sensing"):
    def __init__(self, driver):
        super().__init__()

class Broken(Component, authority="Example", function="sensing"):
    def __init__(self):
        raise OSError("no such device")

class Alien:
    pass

number = 3
"""


class Shipped(Component, authority="Example", function="actuation"):
    """A component that the body has."""

    @command
    async def start(self) -> None:
        """Begin."""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "outside_components.py").write_text(SOURCE)
    (tmp_path / "half_components.py").write_text("import not_there_at_all")
    (tmp_path / "odd_components.py").write_text("raise RuntimeError('odd')")
    (tmp_path / "wrong_components.py").write_text("def broken(:")
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in ("outside", "half", "odd", "wrong"):
        monkeypatch.delitem(sys.modules, f"{name}_components", raising=False)
    return "outside_components"


def made(*names: str, body: object = None, others: tuple[Base, ...] = ()) -> tuple[Base, ...]:
    parser = argparse.ArgumentParser()
    add_component_option(parser)
    chosen = parser.parse_args([part for name in names for part in ("--component", name)])
    return make_components(load_components(chosen.own_components), body, others)


def test_none_is_none(module: str) -> None:
    assert made() == ()


def test_given_twice_adds_both_and_a_constructor_gets_the_body_that_it_asks_for(module: str) -> None:
    body = SimpleNamespace()
    lamp, greeter, second = made(f"{module}:Lamp", f"{module}:Greeter", f"{module}:Renamed", body=body)
    assert [lamp.name, greeter.name, second.name] == ["lamp", "greeter", "second_lamp"]
    assert greeter.body is body  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("outside_components", "write PACKAGE:CLASS, as my_components.greeter:Greeter"),
        (":Lamp", "write PACKAGE:CLASS"),
        ("outside_components:", "write PACKAGE:CLASS"),
        ("nowhere_at_all:Lamp", "there is no module nowhere_at_all; install it, or name its folder in PYTHONPATH"),
        ("nowhere_at_all.deep:Lamp", "there is no module nowhere_at_all;"),
        ("outside_components.deep:Lamp", "there is no module outside_components.deep;"),
        ("half_components:Lamp", "half_components needs not_there_at_all, which is not installed"),
        ("odd_components:Lamp", r"odd_components cannot be imported: RuntimeError\('odd'\)"),
        ("wrong_components:Lamp", r"wrong_components cannot be imported: SyntaxError"),
        ("outside_components:Lamb", "outside_components has no Lamb"),
        ("outside_components:Alien", "Alien is no component: it has to extend openrois.adapter.Component"),
        ("outside_components:number", "number is no component"),
        ("outside_components:Component", "Component is no component"),
        ("outside_components:Demanding", "cannot be made: .*missing 1 required positional argument: 'driver'"),
        ("outside_components:Broken", "cannot be made: no such device"),
    ],
)
def test_a_mistake_is_named(module: str, name: str, said: str) -> None:
    with pytest.raises((ValueError, BadParameter), match=f"^--component {name}:? .*{said}|^--component {name}: {said}"):
        made(name)


def test_two_of_one_name_are_refused(module: str) -> None:
    with pytest.raises(BadParameter, match=r"Lamp: its name 'lamp' is that of a component of --component .*Lamp; let"):
        made(f"{module}:Lamp", f"{module}:Lamp")
    with pytest.raises(BadParameter, match=r"its name 'lamp' is that of a component of the body"):
        made(f"{module}:Lamp", others=(Shipped("lamp"),))
