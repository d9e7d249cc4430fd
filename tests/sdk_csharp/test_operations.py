"""The client for C# under Mono, against a real gateway with real adapters behind it."""

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from openrois.gateway.server import Gateway
from openrois.testing import FaultRelay
from openrois.types.codes import ErrorType
from tests.sdk_csharp.conftest import Start
from tests.support.deployment import Robot as Small
from tests.support.deployment import adapter, gateway, until
from tests.support.fleet import NOON, Robot, everything, fleet
from tests.support.guarded import guarded
from tests.support.streams import SharedCamera
from tests.support.tokens import issue

pytestmark = pytest.mark.timeout(120)


@asynccontextmanager
async def attached(running: Gateway, *robots: Robot) -> AsyncIterator[None]:
    """Attach robots to a gateway for as long as the block lasts."""
    names = {robot.engine_id for robot in robots}
    async with fleet(running.url.replace("http", "ws") + "adapter", *robots):
        await until(running.engine, lambda ids: names <= set(ids))
        yield
    await until(running.engine, lambda ids: not names & set(ids))


async def test_all_operations(start: Start) -> None:
    robot = everything()
    async with gateway() as running, attached(running, robot), start("tour", running.url) as app:
        assert await app.says("connected") == ["openrois.directory", "openrois.lease", "rois.stream", "signaling"]
        assert await app.says("profile") == [["robot"], 17]
        assert await app.says("found") == robot.ref("Navigation")
        assert await app.says("own") == "navigation"
        assert await app.says("parameters") == [["lobby", "café 'n'"], 60000, "time"]
        assert await app.says("travelled") == ["lobby", "café 'n'"]
        assert await app.says("status") == "Ready"
        assert await app.says("detected") == [1, f"{NOON:%Y-%m-%dT%H:%M:%S}", True]
        assert await app.says("languages") == ["en", "ja"]
        assert await app.says("robot") == [["1.0,2.0,0.5"], 1]
        assert await app.says("followed") == ["AbortedException", "Abort"]
        assert await app.says("sequence") == ["Ok", "Ok", "Ok"]
        assert await app.says("result") == ["stream_id"]
        assert await app.says("stream") == "audio_streaming-2"
        await app.says("ready")
        robot.parts["PersonDetection"].report(ErrorType.COMPONENT_INTERNAL_ERROR, "the lens is dirty")
        assert await app.says("fault") == ["ComponentInternalError", "the lens is dirty"]
        assert await app.says("closed") == "Closed"
        await app.ends()
    assert robot.parts["SpeechSynthesis"].parameters["speech_text"] == "Hello!"
    assert robot.parts["SpeechSynthesis"].parameters["volume"] == "70"


async def test_what_is_refused_is_a_typed_exception_that_says_why(start: Start) -> None:
    async with (
        gateway() as running,
        attached(running, everything("robot"), everything("avatar")),
        start("errors", running.url) as app,
    ):
        said = dict([await app.says_something() for _ in range(18)])
        await app.ends()
    kinds = {about: what[0] for about, what in said.items()}
    assert kinds == {
        "absent": "UnsupportedException",
        "several": "BadParameterException",
        "condition": "BadParameterException",
        "unbound": "OutOfResourcesException",
        "unknown": "UnsupportedException",
        "command": "UnsupportedException",
        "value": "BadParameterException",
        "method": "RpcException",
        "params": "RpcException",
        "body": "UnsupportedException",
        "none": "ArgumentException",
        "twice": "ArgumentException",
        "closed": "ConnectionLostException",
        "again": "InvalidOperationException",
        "never": "ConnectionLostException",
        "nobody there": "ConnectionFailedException",
        "address": "ArgumentException",
        "password": "ArgumentException",
    }
    assert "robot/speech_synthesizer, avatar/speech_synthesizer" in said["several"][1]
    assert said["unbound"][1].startswith("rois.command.execute(start of robot/navigation): OUT_OF_RESOURCES (")
    assert said["value"][1] == 'volume: "loud" is not of type int'
    assert "-32601" in said["method"][1]
    assert "component_ref" in said["params"][1]
    assert "there is no body with Lamp; there are: " in said["body"][1]
    assert "avatar (AudioStreaming, " in said["body"][1]
    assert "Reaction is named twice" in said["twice"][1]


async def test_leases_are_asked_for_granted_and_declined(start: Start) -> None:
    async with gateway() as running, attached(running, everything()), start("leaser", running.url) as app:
        assert await app.says("held") == "Held"
        assert await app.says("declined") == "OutOfResourcesException"
        said = dict([await app.says_something(), await app.says_something()])
        assert said == {"granted": "Mine", "lost": "robot/reaction"}
        assert "robot/reaction" in await app.says("stopped")
        assert await app.says("handed back nothing") == "UnsupportedException"
        assert await app.says("gave up") == "TaskCanceledException"
        await app.ends()


async def test_a_part_is_borrowed_from_a_program_and_given_back(start: Start, tmp_path: Path) -> None:
    robot = everything()
    now = time.time()
    tokens = [issue(now, sub="night watch", rank="script"), issue(now, sub="ann", rank="person")]
    async with guarded(tmp_path) as here:
        await here.gateway.engine.attach(robot.registry)
        async with start("sharer", here.gateway.url, TOKENS=" ".join(tokens)) as app:
            assert await app.says("borrowed") == ["Mine", "night watch", "legs"]
            assert await app.says("lent") == [robot.ref("Navigation"), "ann", True]
            assert await app.says("refused") == "OutOfResourcesException"
            assert await app.says("of higher rank") == "OutOfResourcesException"
            assert await app.says("restored") == robot.ref("Navigation")
            assert await app.says("restored") == robot.ref("SpeechSynthesis")
            await app.ends()
    assert robot.parts["SpeechSynthesis"].parameters["speech_text"] == "I go on."


async def test_verbs_of_streams_over_the_extension(start: Start) -> None:
    small = Small()
    async with (
        gateway() as running,
        adapter(running, small.camera, extension=small.streams),
        start("streamer", running.url) as app,
    ):
        assert await app.says("status") == "StreamingNotRunning"
        assert await app.says("suspended") == "StreamingSuspended"
        assert await app.says("change") == [True, True]
        assert await app.says("playout") == "nothing"
        assert await app.says("unknown") == "UnsupportedException"
        await app.ends()
    method, params, _ = small.streams.calls[0]
    assert method == "rois.stream.connect_stream"
    assert [each["value"] for each in params["parameters"]] == ['{"codecs":["video/H264"]}', '{"direction":"recvonly"}']


async def test_verbs_of_streams_in_strict_rois(start: Start) -> None:
    camera = SharedCamera()
    async with gateway() as running, adapter(running, camera), start("streamer", running.url, PLAIN="1") as app:
        assert await app.says("status") == "StreamingRunning"
        assert await app.says("suspended") == "StreamingRunning"
        assert await app.says("change") == [True, True]
        assert await app.says("playout") == "UnsupportedException"
        # It has one stream for all applications, and does not know the ids of others.
        assert await app.says("unknown") == "nothing"
        await app.ends()
    assert camera.asked == ["connect_stream", "the stream", "the stream", "the stream"]


async def test_tokens_are_shown_at_each_connection_and_before_the_present_one_ends(
    start: Start, tmp_path: Path
) -> None:
    now = time.time()
    # The gateway tells at once that the first one ends soon.
    tokens = " ".join([issue(now, exp=int(now) + 30), issue(now, exp=int(now) + 3600)])
    async with (
        guarded(tmp_path) as here,
        FaultRelay(here.gateway.url) as relay,
        start("bearer", relay.url, TOKENS=tokens) as app,
    ):
        assert await app.says("none") == "ConnectionFailedException"
        assert await app.says("empty") == "ConnectionFailedException"
        assert await app.says("connected") == 1
        assert await app.says("renewed") == 2
        relay.cut()
        await app.go_on()
        assert await app.says("again") == 3
        await app.ends()
    assert [line["kind"] for line in here.audited() if line.get("method") == "openrois.auth.refresh"] == ["acted"]
