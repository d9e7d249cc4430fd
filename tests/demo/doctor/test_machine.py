import os
import socket
import time

import pytest
from openrois_body.hearing.sphinx import Sphinx
from openrois_body.vision.cascades import CascadeFinder
from openrois_demo.doctor import avatar, libraries, machine, robot
from openrois_demo.doctor.finding import Level
from openrois_robots.simulated.drawing import renderer
from openrois_streaming.aiortc_internals import trial
from openrois_streaming.codecs import OPUS, VP8


async def test_libraries(monkeypatch: pytest.MonkeyPatch) -> None:
    found = await libraries.libraries()
    assert found.level is Level.OK
    assert "aiortc 1." in found.detail
    monkeypatch.setitem(trial.TESTED, "aiortc", "0.1.")
    assert (await libraries.libraries()).level is Level.FAIL


def test_codecs(monkeypatch: pytest.MonkeyPatch) -> None:
    assert libraries.codecs().level is Level.OK
    monkeypatch.setattr(libraries, "available_codecs", lambda: (VP8, OPUS))
    assert (libraries.codecs().level, libraries.codecs().detail) == (Level.WARN, "VP8, opus; missing: H264 (libx264)")
    monkeypatch.setattr(libraries, "available_codecs", lambda: (VP8,))
    assert libraries.codecs().level is Level.FAIL


def test_the_port_of_the_gateway() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        assert machine.port(taken.getsockname()[1]).level is Level.WARN
    assert machine.port(0).level is Level.OK


def test_a_clock_that_is_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    assert machine.clock().level is Level.OK
    monkeypatch.setattr(time, "time", lambda: 0.0)
    assert machine.clock().level is Level.WARN


def test_a_machine_that_is_busy(monkeypatch: pytest.MonkeyPatch) -> None:
    for load, level in ((0.0, Level.OK), (1000.0, Level.WARN)):
        monkeypatch.setattr(os, "getloadavg", lambda load=load: (load, load, load))
        assert machine.load().level is level


def test_what_sees_and_hears_is_named_with_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert (avatar.vision().level, avatar.vision().advice) == (Level.OK, "")
    monkeypatch.setattr(CascadeFinder, "available", lambda _self: (False, "install cascades"))
    monkeypatch.setattr(Sphinx, "available", lambda _self: (False, "install a recogniser"))
    for found, advice in ((avatar.vision(), "install cascades"), (avatar.hearing(), "install a recogniser")):
        assert (found.level, found.advice) == (Level.WARN, advice)
    assert avatar.hearing().detail == "Sphinx: the avatar recognises no speech"


def test_a_renderer_a_voice_and_a_browser_are_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "find_chromium", lambda: None)
    monkeypatch.setattr(avatar, "find_spec", lambda name: None)
    assert machine.browser().level is avatar.voice().level is Level.WARN
    monkeypatch.setattr(machine, "find_chromium", lambda: "/usr/bin/chromium")
    monkeypatch.setattr(avatar, "find_spec", lambda name: object())
    assert machine.browser().level is avatar.voice().level is Level.OK
    monkeypatch.setattr(avatar, "choose_game_engine", lambda wanted: ("puppet", "install panda3d"))
    assert avatar.game_engine().level is Level.WARN


def test_the_simulated_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    found = robot.simulated_robot()
    assert found.level is Level.OK, found
    assert found.detail.startswith("Panda3D draws 640x360, in ")

    def cannot(*_: object) -> None:
        raise RuntimeError("Panda3D has no graphics pipe here")

    monkeypatch.setattr(renderer, "Renderer", cannot)
    found = robot.simulated_robot()
    assert (found.level, found.detail) == (Level.WARN, "Panda3D has no graphics pipe here")
    assert "libx11-6" in found.advice
