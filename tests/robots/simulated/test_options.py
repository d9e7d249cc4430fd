"""Options and configuration file of the simulated robot."""

import argparse
from pathlib import Path

import pytest
from openrois_robots.adapter.options import AdapterSettings, add_adapter_options, read_adapter_settings
from openrois_robots.simulated.options import TABLES, add_options, read_settings
from openrois_robots.simulated.simulation import SimulationSettings

pytestmark = pytest.mark.extra(name="robot")


def parse(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_adapter_options(parser, "robot", TABLES)
    add_options(parser)
    return parser.parse_args(arguments)


def settings(*arguments: str) -> SimulationSettings:
    return read_settings(parse(*arguments))


def adapter_settings(*arguments: str) -> AdapterSettings:
    return read_adapter_settings(parse(*arguments))


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "robot.toml"
    path.write_text("[base]\nspeed = 0.5\nturn = 1\n[battery]\nlow = 0.3\ndriving = 45\n")
    return path


def test_defaults() -> None:
    assert settings() == SimulationSettings()
    assert adapter_settings().gateways == ("ws://127.0.0.1:8765/adapter",)
    assert (adapter_settings().engine_id, adapter_settings().metrics) == ("robot", None)


def test_a_file_sets_speeds_and_limits(config: Path) -> None:
    simulation = settings("--config", str(config))
    assert (simulation.base.speed, simulation.base.turn) == (0.5, 1.0)
    assert (simulation.battery.low, simulation.battery.driving, simulation.battery.charge) == (0.3, 45.0, 1.0)


def test_options_come_before_the_file(config: Path) -> None:
    given = ("--max-speed", "0.3", "--max-turn", "0.9", "--battery", "40", "--battery-low", "25", "--visitor")
    simulation = settings("--config", str(config), *given)
    assert (simulation.base.speed, simulation.base.turn, simulation.visitor) == (0.3, 0.9, True)
    assert (simulation.battery.charge, simulation.battery.low, simulation.battery.driving) == (0.4, 0.25, 45.0)


def test_network_and_gateway_are_those_of_every_adapter() -> None:
    chosen = adapter_settings(
        "--gateway", "https://robots.example,wss://b/adapter", "--engine-id", "anna", "--udp-ports", "50000-50100"
    )
    assert adapter_settings("--metrics", "9470").metrics == ("127.0.0.1", 9470)
    assert (chosen.gateways, chosen.engine_id) == (("wss://robots.example/adapter", "wss://b/adapter"), "anna")
    assert chosen.network.ports is not None
    assert chosen.network.ports.first == 50_000


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("--max-speed", "9"), "base.speed must be between 0.05 and 2, not 9"),
        (("--battery", "101"), "battery.charge must be between 0 and 1, not 1.01"),
        (("--config", "/nowhere/robot.toml"), "--config: /nowhere/robot.toml cannot be read: No such file"),
    ],
)
def test_wrong_options_are_refused(arguments: tuple[str, ...], why: str) -> None:
    with pytest.raises(ValueError, match=why.replace(".", r"\.")):
        settings(*arguments)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[bas]\nspeed = 1", "there is no table 'bas'; there are base and battery"),
        (
            "[base]\nspeeed = 1",
            "base.speeed is not known; base has speed, turn, acceleration, braking",
        ),
        ("[base]\nspeed = 'fast'", "base.speed must be a number, not 'fast'"),
        ("[base]\nspeed = true", "base.speed must be a number, not True"),
        ("base = 3", "base must be a table"),
        ("[base]\nspeed = 30", "base.speed must be between 0.05 and 2, not 30"),
        pytest.param("[base]\nspeed = 1" + 400 * "0", "base.speed must be a number, not one of 1329 bits", id="large"),
        pytest.param("a = " + 20_000 * "[", "is no TOML: it is nested too deeply", id="deep"),
        pytest.param("a = " + 5_000 * "1", "is no TOML: ", id="long"),
        ("[battery]\nlow = nan", "battery.low must be between 0 and 0.9, not nan"),
        ("[base", "is no TOML"),
        ("#" * (1 << 20) + "#", "is larger than 1048576 bytes"),
    ],
)
def test_wrong_files_are_refused(text: str, why: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=why.replace(".", r"\.")) as raised:
        settings("--config", str(path))
    assert str(raised.value).startswith(f"--config: {path}")


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(ValueError, match="is no TOML"):
        settings("--config", str(path))
