"""The TypeScript SDK in Node, as a package, against a real gateway with a real adapter behind it."""

import re
import signal
import subprocess
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from openrois.adapter.running import serve
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.types.codes import ErrorType
from tests.support.components import Lamp
from tests.support.demo import free_port
from tests.support.deployment import gateway, until
from tests.support.fleet import NOON, Robot, everything, fleet
from tests.support.ground import gateway_program
from tests.support.guarded import guarded
from tests.support.json_program import JsonProgram
from tests.support.tokens import issue
from tests.web_sdk.conftest import Start


@asynccontextmanager
async def attached(running: Gateway, robot: Robot) -> AsyncIterator[None]:
    """Attach a robot to a gateway for as long as the block lasts."""
    async with fleet(running.url.replace("http", "ws") + "adapter", robot):
        await until(running.engine, lambda ids: robot.engine_id in ids)
        yield
    await until(running.engine, lambda ids: robot.engine_id not in ids)


def own_websocket(node: Path) -> list[str]:
    """Return the flags with which Node has a WebSocket of its own."""
    version = subprocess.run([node, "--version"], capture_output=True, text=True, check=True, timeout=10).stdout
    found = re.match(r"v(\d+)", version)
    assert found is not None
    return ["--experimental-websocket"] if int(found[1]) < 22 else []


@pytest.mark.parametrize("websocket", ["ws", "own"])
async def test_all_operations_work_in_node(start: Start, node: Path, websocket: str) -> None:
    robot = everything()
    flags = own_websocket(node) if websocket == "own" else []
    async with gateway() as running, attached(running, robot), start("tour.mjs", running.url, *flags) as app:
        connected = await app.says("connected")
        assert connected["extensions"] == ["rois.stream", "signaling", "openrois.directory", "openrois.lease"]
        assert connected["websocket"] is (websocket == "own") or not own_websocket(node)
        assert await app.says("profile") == [["robot"], 17]
        assert await app.says("found") == [robot.ref("SpeechSynthesis")]
        assert await app.says("absent") == "UNSUPPORTED"
        assert await app.says("unbound") == "OUT_OF_RESOURCES"
        parameters = {"target_positions": ["lobby", "café 'n'"], "time_limit": 60000, "routing_policy": "time"}
        assert await app.says("parameters") == parameters
        assert await app.says("passed") == "lobby"
        assert await app.says("travelled") == ["lobby", "café 'n'"]
        assert await app.says("status") == {"status": "READY"}
        assert await app.says("detected") == {"number": 1, "timestamp": NOON.strftime("%Y-%m-%dT%H:%M:%S.000Z")}
        assert await app.says("detail") == ["number", "timestamp"]
        assert await app.says("languages") == {"languages": ["en", "ja"]}
        assert await app.says("robot") == ["position_data", "robot_ref", "timestamp"]
        assert await app.says("stream") == ["audio_streaming-1", {"status": "STREAMING_SUSPENDED"}]
        assert await app.says("followed") == ["CommandFailed", "ABORT"]
        assert await app.says("sequence") == ["OK", "OK", "OK"]
        assert await app.says("result") == ["stream_id"]
        await app.says("ready")
        robot.parts["PersonDetection"].report(ErrorType.COMPONENT_INTERNAL_ERROR, "the lens is dirty")
        assert await app.says("fault") == ["COMPONENT_INTERNAL_ERROR", "the lens is dirty"]
        assert await app.says("unknown") == ["RpcError", -32601]
        assert await app.says("wrong") == ["RpcError", -32602]
        assert await app.says("reader") == "ended"
        await app.ends()
    assert robot.parts["SpeechSynthesis"].parameters["speech_text"] == "Hello!"
    assert robot.parts["SpeechSynthesis"].parameters["volume"] == "70"


async def test_token_is_sent_outside_of_a_page(start: Start, node: Path, tmp_path: Path) -> None:
    async with (
        guarded(tmp_path) as here,
        start("bearer.mjs", here.gateway.url, *own_websocket(node), token=issue(time.time())) as app,
    ):
        assert await app.says("own") == "connected"
        assert await app.says("ws") == "connected"
        await app.ends()


async def test_a_part_is_borrowed_from_a_program_and_given_back(start: Start, tmp_path: Path) -> None:
    robot = everything()
    now = time.time()
    tokens = [issue(now, sub="night watch", rank="script"), issue(now, sub="ann", rank="person")]
    async with AsyncExitStack() as stack:
        here = await stack.enter_async_context(guarded(tmp_path))
        await here.gateway.engine.attach(robot.registry)
        app = await stack.enter_async_context(start("sharer.mjs", here.gateway.url, token=" ".join(tokens)))
        assert await app.says("borrowed") == ["MINE", "night watch", "legs"]
        assert await app.says("lent") == ["ann", True]
        code, reason = await app.says("refused")
        assert code == "OUT_OF_RESOURCES"
        assert "was taken for a time by ann" in reason
        assert await app.says("of higher rank") == "OUT_OF_RESOURCES"
        assert await app.says("restored") == robot.ref("Navigation")
        assert await app.says("restored") == robot.ref("SpeechSynthesis")
        await app.ends()
    assert robot.parts["SpeechSynthesis"].parameters["speech_text"] == "I go on."


async def comes_back(app: JsonProgram) -> list[tuple[str, object]]:
    """Return what the application says until its binding and subscription are restored."""
    said: list[tuple[str, object]] = []
    while [about for about, _ in said].count("restored") < 2:
        said.append(await app.says_something())
    assert ("restored", ["binding"]) in said
    assert ("restored", ["subscription"]) in said
    return said


async def test_bindings_and_subscriptions_are_restored(start: Start) -> None:
    robot = everything()
    async with AsyncExitStack() as stack:
        async with gateway() as running:
            async with attached(running, robot):
                app = await stack.enter_async_context(start("keeper.mjs", running.url))
                await app.says("ready")
                await app.go_on()
                assert await app.says("reached") == "place 0"
            # The engine is gone: both are lost, which is reported once.
            lost = [await app.says("lost"), await app.says("lost")]
            assert sorted(lost) == [["binding", "UNSUPPORTED"], ["subscription", "UNSUPPORTED"]]
            async with attached(running, robot):
                await comes_back(app)
                await app.go_on()
                assert await app.says("reached") == "place 1"
            await app.says("lost")
            await app.says("lost")
        # The gateway is gone, too.
        await app.says("waiting")
        await app.says("waiting")
        # The robot's name for its component is all that this gateway has in common with the one before.
        port = urlsplit(running.url).port
        assert port is not None
        async with run_gateway(GatewaySettings(port=port)) as another, attached(another, robot):
            said = await comes_back(app)
            assert ("connected", None) in said
            await app.go_on()
            assert await app.says("reached") == "place 2"
            await app.go_on()
            await app.ends()


async def test_the_directory_is_followed_and_only_what_changed_is_renewed(start: Start) -> None:
    async with AsyncExitStack() as stack:
        running = await stack.enter_async_context(gateway())
        await stack.enter_async_context(attached(running, everything("a")))
        async with attached(running, everything("b")):
            app = await stack.enter_async_context(start("follower.mjs", running.url))
            assert await app.says("engines") == ["a", "b", "gateway"]
            assert await app.says("profiles") == [34, 17, 1]
            assert await app.says("same") is True
            await app.says("ready")
        assert await app.says("changed") == ["b"]
        await app.go_on()
        assert await app.says("left") == ["a", "gateway"]
        async with attached(running, everything("b")):
            assert await app.says("changed") == ["b"]
            await app.go_on()
            assert await app.says("back") == ["a", "b", "gateway"]
            assert await app.says("restored") == "component_ref = 'b/navigation'"
            assert await app.says("renewed") == ["component_ref = 'b/navigation'"]
            assert await app.says("lists") == 1
            await app.ends()


async def test_after_a_crash_of_the_gateway_each_command_has_its_end(start: Start, tmp_path: Path) -> None:
    port = str(free_port())
    url = f"http://127.0.0.1:{port}/"
    options = ("--port", port, "--journal", str(tmp_path / "journal"))
    async with AsyncExitStack() as stack:
        async with gateway_program(*options, log=tmp_path / "log") as running:
            await stack.enter_async_context(serve(Lamp(), engine_id="robot", gateway=url))
            app = await stack.enter_async_context(start("survivor.mjs", url))
            await app.says("ready")
            running.signal(signal.SIGKILL)
            await running.ended()
        async with gateway_program(*options, log=tmp_path / "log"):
            restarted = ["ERROR", "the gateway was restarted"]
            assert await app.says("ended") == [restarted, restarted, ["ConnectionLost"]]
            await app.ends()
