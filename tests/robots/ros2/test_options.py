"""The command `openrois robot ros2`: its mapping file, its node, and what is said where it cannot run."""

import argparse
import builtins
import sys
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from openrois_robots import command as robots
from openrois_robots.ros2.command import backend_of
from openrois_robots.ros2.cyclone.backend import CycloneBackend
from openrois_robots.ros2.mapping.settings import Ros
from openrois_robots.ros2.options import domain_of, read_settings
from openrois_robots.ros2.rclpy_backend import RclpyBackend

from openrois.extras import MissingExtra

pytestmark = pytest.mark.extra(name="ros2")


def chosen(path: Path | None) -> argparse.Namespace:
    return argparse.Namespace(config=path)


def test_a_mapping_file_is_required() -> None:
    with pytest.raises(ValueError, match="--config is missing: it names the mapping file"):
        read_settings(chosen(None))


def test_what_is_wrong_in_it_is_said_with_its_name(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[odometry]\n")
    with pytest.raises(ValueError, match=r"--config: .*robot\.toml: odometry\.topic is missing"):
        read_settings(chosen(path))
    path.write_text("[odometry")
    with pytest.raises(ValueError, match=r"--config: .*robot\.toml is no TOML"):
        read_settings(chosen(path))
    path.write_text('[odometry]\ntopic = "odom"\n')
    assert read_settings(chosen(path)).odometry is not None


def test_the_command_ends_with_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        robots.main(["ros2"])
    assert "--config is missing" in capsys.readouterr().err


@pytest.mark.parametrize(("text", "domain"), [("", 0), ("7", 7), ("232", 232)])
def test_the_domain_is_that_of_the_environment(text: str, domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    assert domain_of(Ros()) == domain
    assert domain_of(Ros(domain=3)) == 3


@pytest.mark.parametrize("text", ["-1", "233", "one", "٣"])
def test_a_domain_that_is_none_is_said(text: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    path = tmp_path / "robot.toml"
    path.write_text('[odometry]\ntopic = "odom"\n')
    with pytest.raises(ValueError, match=r"ROS_DOMAIN_ID must be between 0 and 232, not .*; ros\.domain is another"):
        read_settings(chosen(path))


@pytest.mark.parametrize(
    ("backend", "installed", "kind"),
    [
        ("auto", True, RclpyBackend),
        ("auto", False, CycloneBackend),
        ("cyclonedds", True, CycloneBackend),
        ("rclpy", False, RclpyBackend),
    ],
)
def test_the_node_is_of_ros_where_there_is_one(backend: str, installed: bool, kind: type[object]) -> None:
    with patch("openrois_robots.ros2.command.is_rclpy_installed", lambda: installed):
        assert isinstance(backend_of(Ros(domain=1, backend=backend, interfaces="/nowhere")), kind)


def test_without_cyclone_dds_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def lacking(name: str, *arguments: Any, **named: Any) -> Any:
        if name.partition(".")[0] == "cyclonedds":
            raise ModuleNotFoundError("No module named 'cyclonedds'", name="cyclonedds")
        return real(name, *arguments, **named)

    for name in [each for each in sys.modules if each.startswith("openrois_robots.ros2.cyclone")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr("openrois.extras.find_spec", lambda _name: None)
    monkeypatch.setattr(builtins, "__import__", lacking)
    with pytest.raises(MissingExtra, match=r"cyclonedds is not installed: run `pip install 'openrois\[ros2\]'`"):
        backend_of(Ros(domain=1, backend="cyclonedds"))


def test_a_type_that_is_not_known_ends_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.toml"
    path.write_text('[ros]\nbackend = "cyclonedds"\ndomain = 99\n[speech]\ntopic = "say"\ntype = "kit_msgs/msg/Kit"\n')
    assert robots.main(["ros2", "--config", str(path)]) == 1
    assert "kit_msgs/msg/Kit is not known: name the folder" in capsys.readouterr().err
