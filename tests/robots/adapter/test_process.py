"""The command of a robot: metrics and health beside its adapter, and what ends it."""

import argparse
import json
import os
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import aiohttp
import pytest
from openrois_media.streams import AdapterStreams
from openrois_robots.adapter.hosting import RunningRobot
from openrois_robots.adapter.options import AdapterSettings
from openrois_robots.adapter.process import RobotCommand

from openrois.adapter.running import hosted
from openrois.errors import BadParameter
from tests.support.demo import free_port

pytestmark = pytest.mark.extra(name="robot")


def of(run: Any) -> RobotCommand[str]:
    def add_options(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--robot", default="there")

    def read(chosen: argparse.Namespace) -> str:
        if chosen.robot == "nowhere":
            raise ValueError("--robot must not be nowhere")
        return str(chosen.robot)

    return RobotCommand("kit", "A robot.", "robot", "none", add_options, read, run)


def test_figures_and_health_are_served_and_say_what_is_lacking() -> None:
    port, answers = free_port(), dict[str, tuple[int, str]]()

    @asynccontextmanager
    async def run(settings: AdapterSettings, robot: str) -> AsyncIterator[RunningRobot]:
        assert (settings.engine_id, robot) == ("robot", "here")
        streams = AdapterStreams("robot", {})

        async with streams as extension, hosted("robot", extension=extension) as host:
            yield RunningRobot(host, streams.collector().snapshot, {"the robot: it is asleep": lambda: False})

    async def ask() -> None:
        async with aiohttp.ClientSession() as session:
            for path in ("/metrics", "/healthz", "/readyz"):
                async with session.get(f"http://127.0.0.1:{port}{path}") as answer:
                    answers[path] = answer.status, await answer.text()
        os.kill(os.getpid(), signal.SIGTERM)

    class Served:
        """In place of a gateway that never accepts it: what probes ask while it waits."""

        is_attached = False

        def __init__(self, _engine_id: str) -> None: ...

        async def serve(self, *_what: object) -> None:
            await ask()

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("openrois_media.process.AdapterProcess", Served)
        assert of(run).main(["--robot", "here", "--metrics", str(port)]) == 0
    assert answers["/healthz"][0] == answers["/metrics"][0] == 200
    assert "openrois_" in answers["/metrics"][1]
    assert answers["/readyz"][0] == 503
    assert json.loads(answers["/readyz"][1])["lacking"] == [
        "the gateway: it has not accepted this adapter",
        "the robot: it is asleep",
    ]


def test_wrong_options_of_the_robot_end_with_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        of(None).main(["--robot", "nowhere"])
    assert "--robot must not be nowhere" in capsys.readouterr().err


@pytest.mark.parametrize("error", [BadParameter("'a b' cannot be part of a reference"), OSError("no route to host")])
def test_a_robot_that_cannot_run_ends_the_command(error: Exception, capsys: pytest.CaptureFixture[str]) -> None:
    @asynccontextmanager
    async def run(_settings: AdapterSettings, _robot: str) -> AsyncIterator[RunningRobot]:
        raise error
        yield

    assert of(run).main([]) == 1
    assert capsys.readouterr().err.endswith(f"openrois robot kit: {error}\n")
