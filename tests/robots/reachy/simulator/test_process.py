"""The simulated daemon as a program."""

import pytest
from openrois_robots.reachy.simulator.__main__ import main

from tests.support.reachy import Watcher, daemon_process, linked
from tests.support.robots import until


async def test_it_begins_asleep_hears_a_voice_and_ends_with_a_signal() -> None:
    async with daemon_process("--asleep", "--media", "--sound-from", "90") as daemon:
        async with linked(daemon.address) as robot, Watcher.watching(daemon.address) as watcher:
            assert robot.state.told.motors == "disabled"
            assert robot.state.told.sound_problem == ""
            assert (await robot.state.daemon.get("/api/state/doa"))["speech_detected"]
            await robot.state.daemon.post("/api/motors/set_mode/enabled")
            await robot.state.daemon.post("/api/move/play/wake_up")
            await until(lambda: watcher.posture.roll > 0.3)
            await until(lambda: watcher.posture.roll < 0.01)
        daemon.process.terminate()
        assert await daemon.process.wait() == 0


def test_a_port_that_is_taken_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--host", "192.0.2.1", "--port", "1"]) == 1
    assert "192.0.2.1" in capsys.readouterr().err
