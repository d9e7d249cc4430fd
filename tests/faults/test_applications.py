"""F10 to F17: applications that go half open, vanish, loop, repeat themselves, or read too slowly."""

import asyncio
import socket
from pathlib import Path

import pytest

from tests.support.ground import Ground, ground, turns
from tests.support.invariants import PATIENCE, Witness
from tests.support.plain import TOY, plain_adapter
from tests.support.seeds import ALL, SOME

LAMP, BELL = "robot/lamp", "robot/bell"


async def free_again(place: Ground, other: Witness) -> None:
    """Wait until another application can bind the lamp."""
    async with asyncio.timeout(5):
        while await other.bind() != "OK":
            await turns(place.chance)


@pytest.mark.parametrize("seed", SOME)
async def test_f10_f11_a_half_open_application(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with ground(seed, tmp_path, caplog, quick=True) as place:
        await place.robot(relayed=False)
        async with place.book.witness(place.relay.url) as gone:
            other = await place.witness()
            assert await gone.bind() == "OK"
            await gone.subscribe("rang", BELL)
            assert await gone.execute("never heard of") == "OK"
            await asyncio.sleep(place.chance.random() * 0.1)
            place.relay.half_open()
            place.book.holders.clear()
            place.lamp.may_end.set()
            await free_again(place, other)
            place.relay.cut()


@pytest.mark.parametrize("seed", ALL)
async def test_f11_an_application_that_vanishes_loses_its_leases_after_the_grace(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with ground(seed, tmp_path, caplog, lease_grace=0.02) as place:
        await place.robot()
        other = await place.witness(extended=True)
        async with place.book.witness(place.gateway.url, extended=True) as gone:
            assert await gone.bind() == "OK"
            assert (await gone.ask("openrois.lease.token"))["return_code"] == "OK"
            await gone.subscribe("rang", BELL)
            assert await gone.execute("goes on") == "OK"
            await place.running()
            await turns(place.chance)
            gone.socket.transport.abort()
            await gone.gone.wait()
            place.book.holders.clear()
            if place.chance.random() < 0.5:
                place.lamp.may_end.set()
            await free_again(place, other)
            place.lamp.may_end.set()


@pytest.mark.parametrize("seed", ALL)
async def test_f11_an_application_that_is_back_in_time_keeps_its_leases(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with ground(seed, tmp_path, caplog, lease_grace=5.0) as place:
        await place.robot(relayed=False)
        other = await place.witness(extended=True)
        half_open = place.chance.random() < 0.5
        async with place.book.witness(place.relay.url, extended=True) as first:
            assert await first.bind() == "OK"
            token = (await first.ask("openrois.lease.token"))["token"]
            assert await first.execute("goes on") == "OK"
            await place.running()
            await turns(place.chance)
            if half_open:
                # Its link is dead, and neither side can know: the gateway would, after 9 s.
                place.relay.half_open()
            else:
                place.relay.cut()
                await first.gone.wait()
            assert await other.bind() == "OUT_OF_RESOURCES"
            again = await place.witness(extended=True)
            again.inherits(first)
            assert (await again.ask("openrois.lease.resume", token=token))["return_code"] == "OK"
            place.relay.cut()
        assert await other.bind() == "OUT_OF_RESOURCES"
        thief = await place.witness(extended=True)
        assert (await thief.ask("openrois.lease.resume", token=token))["return_code"] != "OK"
        place.lamp.may_end.set()
        assert await again.end_of("goes on") == "OK"
        assert await again.execute("next", "switch") == "OK"
        assert await again.end_of("next") == "OK"
        assert await again.code("rois.command.release", component_ref=LAMP) == "OK"
        assert await other.bind() == "OK"


@pytest.mark.parametrize("seed", SOME)
async def test_f12_one_that_comes_and_goes(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with ground(seed, tmp_path, caplog) as place:
        await place.robot()
        for number in range(60):
            async with place.book.witness(place.gateway.url) as app:
                async with asyncio.timeout(5):
                    while await app.bind() != "OK":
                        await turns(place.chance)
                if place.chance.random() < 0.5:
                    await app.subscribe("rang", BELL)
                if place.chance.random() < 0.3:
                    assert await app.execute(f"c{number}", "switch") == "OK"
                    await app.settled()
                if place.chance.random() < 0.3:
                    await app.code("rois.command.release", component_ref=LAMP)
                if place.chance.random() < 0.5:
                    app.socket.transport.abort()
                    await app.gone.wait()
            place.book.holders.clear()


@pytest.mark.parametrize("seed", ALL)
async def test_f13_f14_ids_that_come_twice(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with ground(seed, tmp_path, caplog) as place:
        plain = await place.stack.enter_async_context(plain_adapter(place.gateway))
        await place.attached("plain")
        await place.robot()
        one, two = await place.witness(), await place.witness()
        assert await one.bind(TOY) == "OK"
        assert await two.bind() == "OK"
        many = place.chance.randint(2, 5)
        unit = {"component_ref": TOY, "command_type": "start", "command_id": "c", "arguments": []}
        asked = [await one.begin("rois.command.execute", command_unit_list=[unit]) for _ in range(many)]
        codes = [(await answer)["result"]["return_code"] for answer in asked]
        assert codes == ["OK"] + ["BAD_PARAMETER"] * (many - 1)
        # Another application may use the same id: each hears of its own.
        assert await two.execute("c", "switch") == "OK"
        assert await one.end_of("c") == "OK"
        assert await two.end_of("c") == "OK"
        assert [name for name, _ in plain.asked].count("rois.command.execute") == 1
        assert await one.execute("c", "start", TOY) == "BAD_PARAMETER"


@pytest.mark.parametrize("seed", SOME)
async def test_f15_f16_a_storm_of_events_and_a_slow_reader(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    # The applications of this process read megabytes.
    async with ground(seed, tmp_path, caplog, longest=1.0) as place:
        await place.robot()
        await place.robot(type(place.lamp)("lamp"), engine_id="calm")
        quick, slow = await place.witness(extended=True), await place.witness(extended=True)
        for each in (quick, slow):
            await each.subscribe("rang", BELL)
        sent = 0
        slow.socket.transport.pause_reading()
        # Else the system keeps everything for the slow reader.
        slow.socket.transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 64 << 10)
        tune = "x" * 16_000
        for _ in range(20):
            for _ in range(place.chance.randint(30, 60)):
                place.bell.ring(f"{sent}{tune}")
                sent += 1
            assert await quick.execute(f"c{sent}", "switch", "calm/lamp") == "OUT_OF_RESOURCES"
        for each in (quick, slow):
            async with asyncio.timeout(PATIENCE):
                while len(each.events) + each.dropped < sent:
                    await each.ask("rois.system.connect")
            # The storm has passed by now: nothing of it waits in front of the gateway.
            slow.socket.transport.resume_reading()
            heard = [int(event["results"][0]["value"].rstrip("x")) for event in each.events]
            assert heard == sorted(set(heard)), "out of order"
            assert len(heard) + each.dropped == sent, "lost without a word (I6)"
        assert slow.dropped


@pytest.mark.parametrize("seed", ALL)
async def test_f17_details_that_have_expired(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with ground(seed, tmp_path, caplog) as place:
        plain = await place.stack.enter_async_context(plain_adapter(place.gateway))
        await place.attached("plain")
        app = await place.witness()
        await app.subscribe("laughed", TOY)
        subscribe_id = f"plain/sub-{plain.minted}"
        years = [place.chance.randint(1990, 2020) for _ in range(3)] + [2060, 2061]
        place.chance.shuffle(years)
        for number, year in enumerate(years):
            await plain.tell(
                "rois.event.notify_event",
                event_id=f"plain/evt-{number}",
                event_type="laughed",
                subscribe_id=subscribe_id,
                expire=f"{year}-01-01T00:00:00+00:00",
                results=[{"name": "text", "data_type_ref": "string", "value": "ha"}],
            )
        async with asyncio.timeout(5):
            while len(app.events) < len(years):
                await turns(place.chance)
        for event, year in zip(app.events, years, strict=True):
            code = await app.code("rois.event.get_event_detail", event_id=event["event_id"], condition="")
            assert code == ("OK" if year > 2030 else "BAD_PARAMETER")
