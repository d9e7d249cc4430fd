"""Operating an avatar by hand, whole: application, gateway, adapter, WebRTC, and a game engine that takes notes.

When the figure stops is printed, and asserted where a clock is turned by hand (`tests/body/teleoperation`).
"""

import asyncio
import json
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from openrois_avatar.link.messages import Drive, Halt, Quit
from openrois_signaling.messages import Offer
from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink
from openrois_streaming.testing.input_sender import InputSender

from openrois.gateway.server import Gateway
from tests.support.deployment import Application, application
from tests.support.operated import NotingEngine, operated_avatar
from tests.support.teleoperation import Hand

pytestmark = pytest.mark.media

REF = "avatar/teleoperation"


@dataclass
class Operator:
    """An application with a picture of the avatar, and hands."""

    app: Application
    sink: MeasuringSink
    hand: Hand = field(default_factory=Hand)

    @property
    def input(self) -> InputSender:
        assert self.sink.input is not None
        return self.sink.input

    async def hold(self, seconds: float) -> float:
        """Hold a key as a page does; return when the last message left."""
        ends = time.monotonic() + seconds
        while True:
            self.input.send_message(self.hand.state())
            sent = time.monotonic()
            if sent >= ends:
                return sent
            await asyncio.sleep(0.08)

    async def start(self) -> None:
        while (await self.asked("component_status"))["status"] != "READY":
            pass
        assert await self.app.code("rois.command.bind", component_ref=REF) == "OK"
        unit = {"component_ref": REF, "command_type": "start", "command_id": "start", "arguments": []}
        assert await self.app.code("rois.command.execute", command_unit_list=[unit]) == "OK"
        while (await self.operation())["operated"] != "true":
            pass

    async def operation(self) -> dict[str, str]:
        return await self.asked("operation")

    async def asked(self, query_type: str) -> dict[str, str]:
        condition = f"component_ref = '{REF}'"
        answer = await self.app.ask("rois.query.query", query_type=query_type, condition=condition)
        return {each["name"]: each["value"] for each in answer["results"]}


@dataclass
class House:
    gateway: Gateway
    engine: NotingEngine

    @asynccontextmanager
    async def operator(self, path: ImpairedPath | None = None) -> AsyncIterator[Operator]:
        """An application that sees the avatar and could operate it."""
        async with MeasuringSink(path=path) as sink, application(self.gateway) as app:
            await app.ask("openrois.hello", version="1", extensions=[])
            wish = json.dumps({"direction": "recvonly", "input": True})
            parameter = {"name": "transport_parameters", "data_type_ref": "String", "value": wish}
            asked: dict[str, Any] = {"component_ref": "avatar/video_streaming", "parameters": [parameter]}
            assert await app.code("rois.stream.connect_stream", **asked) == "OK"
            offer = Offer.model_validate(await app.next("signaling.offer"))
            assert await app.code("signaling.answer", **(await sink.respond(offer)).wire()) == "OK"
            await sink.until(lambda: sink.input is not None and sink.input.are_open)
            yield Operator(app, sink)


@pytest.fixture
async def house(tmp_path: Path) -> AsyncIterator[House]:
    async with operated_avatar(tmp_path) as (running, engine):
        yield House(running, engine)


def told(what: str, stopped: float, since: float, last_drive: float) -> None:
    print(f"\n{what}: halt {(stopped - since) * 1000:.0f} ms after, {(stopped - last_drive) * 1000:.0f} ms after drive")


async def test_the_network_is_cut_while_a_key_is_held(house: House, capsys: pytest.CaptureFixture[str]) -> None:
    path = ImpairedPath()
    async with path, house.operator(path) as operator:
        await operator.start()
        assert (
            await operator.app.code("rois.event.subscribe", event_type="stopped", condition=f"component_ref = '{REF}'")
            == "OK"
        )
        await operator.hold(0.5)
        # Where a busy machine stood still for so long, the figure has stopped before, and drives again.
        while len(house.engine.times(Drive)) < 5 or house.engine.times(Halt)[-1:] > house.engine.times(Drive)[-1:]:
            await operator.hold(0.1)
        for direction in (path.up, path.down):
            direction.change(loss=1.0)
        cut = time.monotonic()
        await asyncio.gather(operator.hold(1.0), house.engine.until(lambda: house.engine.times(Halt)[-1:] > [cut]))
        halted, driven = house.engine.times(Halt)[-1], house.engine.times(Drive)
        with capsys.disabled():
            told("network cut", halted, cut, driven[-1])
        assert halted > driven[-1]
        assert house.engine.inputs[-1] == "release"
        heard = await operator.app.next("rois.event.notify_event")
        detail = await operator.app.ask("rois.event.get_event_detail", event_id=heard["event_id"], condition="")
        assert [each["value"] for each in detail["results"]] == ["no input came for 0.4 s"]
        operation = await operator.operation()
        assert (operation["active"], operation["stopped_because"]) == ("false", "no input came for 0.4 s")


async def test_on_a_long_way_the_figure_goes_slower_and_at_full_speed_when_it_is_short_again(house: House) -> None:
    """F35: what takes 0.7 s there and back is driven at five sevenths of the speed."""
    path = ImpairedPath(Impairments(delay=0.35), Impairments(delay=0.35))
    async with path, house.operator(path) as operator:
        await operator.start()
        async with asyncio.timeout(60):
            while float((await operator.operation())["pace"]) == 1.0:
                await operator.hold(0.2)
            pace = float((await operator.operation())["pace"])
            assert 0.3 < pace < 0.75
            speeds = [each.ahead for _, each in house.engine.heard if isinstance(each, Drive)]
            assert min(speeds) <= 0.8 * 0.75
            for direction in (path.up, path.down):
                direction.change(delay=0.0)
            while (await operator.operation())["pace"] != "1.0":
                await operator.hold(0.2)
        assert (await operator.operation())["ahead"] == "0.8"


async def test_the_application_closes_its_end_while_a_key_is_held(
    house: House, capsys: pytest.CaptureFixture[str]
) -> None:
    async with house.operator() as operator:
        await operator.start()
        sent = await operator.hold(0.3)
        await operator.sink.__aexit__()
        await house.engine.until(lambda: house.engine.times(Halt))
        with capsys.disabled():
            told("peer closed", house.engine.times(Halt)[0], sent, house.engine.times(Drive)[-1])
        assert (await operator.operation())["stopped_because"] in {
            "the application closed its data channels",
            "the application closed the peer connection",
            # On a busy machine the operator may be missed before its end is heard.
            "no input came for 0.4 s",
        }


async def test_the_application_goes_while_a_key_is_held(house: House, capsys: pytest.CaptureFixture[str]) -> None:
    async with house.operator() as operator:
        await operator.start()
        sent = await operator.hold(0.3)
        await operator.app.socket.close()
        await house.engine.until(lambda: house.engine.times(Halt))
        with capsys.disabled():
            told("application gone", house.engine.times(Halt)[0], sent, house.engine.times(Drive)[-1])


async def test_only_the_binding_client_operates(house: House) -> None:
    async with house.operator() as ann, house.operator() as bob:
        await ann.start()
        assert await bob.app.code("rois.command.bind", component_ref=REF) == "OUT_OF_RESOURCES"
        await bob.hold(0.2)
        await bob.sink.until(lambda: bob.input.received)
        assert json.loads(bob.input.received[0]) == {
            "event": "refused",
            "reason": "avatar/teleoperation has to be bound and started first",
        }
        assert house.engine.times(Drive) == []
        ann.input.send_message(ann.hand.key("KeyW"))
        await house.engine.until(lambda: house.engine.times(Drive))
        ann.input.send_message(ann.hand.key("KeyW", down=False))
        await house.engine.until(lambda: house.engine.times(Halt))
        operation = await ann.operation()
        assert (int(operation["taken"]), int(operation["refused"]) > 0) == (2, True)
        assert await ann.app.code("rois.command.release", component_ref=REF) == "OK"
        assert await ann.app.completed("start") == {"start": "ABORT"}
        assert ann.app.reasons["start"] == "the component was released"
        await bob.start()
        bob.input.send_message(bob.hand.key("KeyW"))
        await house.engine.until(lambda: len(house.engine.times(Drive)) == 2)
        assert Quit not in {type(command) for _, command in house.engine.heard}
