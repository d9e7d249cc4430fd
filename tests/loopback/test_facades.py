"""Game engines that do WebRTC themselves, behind a gateway: their media comes straight to who asked for it."""

import asyncio
from pathlib import Path

import pytest
from openrois_avatar.link.client import LinkClient
from openrois_avatar.link.messages import Completed, Pause, React
from openrois_signaling.messages import Offer
from openrois_streaming.testing.sink import MeasuringSink

from tests.support.avatar_link import HELLO
from tests.support.deployment import Application, application
from tests.support.streamers import FakeStreamer, FakeUnity, FakeUnreal, house, streaming
from tests.support.viewer import STATUS

pytestmark = [pytest.mark.media, pytest.mark.timeout(60)]

VIDEO, AUDIO, REACTION = "avatar/video_streaming", "avatar/audio_streaming", "avatar/reaction"
NOD = "urn:x-rois:def:reaction:OMG::1"
ENGINES: dict[str, type[FakeStreamer]] = {"unreal": FakeUnreal, "unity-render-streaming": FakeUnity}


async def connected(app: Application, ref: str) -> str:
    answer = await app.ask("rois.stream.connect_stream", component_ref=ref)
    assert answer["return_code"] == "OK", app.reasons
    return str(answer["stream_id"])


async def both_connected(app: Application) -> list[str]:
    """Connect picture and sound at once, as soon as the game engine is there."""
    while (answer := await app.ask("rois.stream.connect_stream", component_ref=VIDEO))["return_code"] != "OK":
        pass
    assert await app.code("rois.stream.disconnect_stream", stream_id=answer["stream_id"]) == "OK"
    asked = [await app.begin("rois.stream.connect_stream", component_ref=ref) for ref in (VIDEO, AUDIO)]
    return [(await app.answer(each))["result"]["stream_id"] for each in asked]


async def answered(app: Application, sink: MeasuringSink) -> Offer:
    """Answer the next offer with all that is in it."""
    offer = Offer.model_validate(await app.next("signaling.offer"))
    answer = await sink.respond(offer)
    assert await app.code("signaling.answer", **answer.wire()) == "OK"
    return offer


async def usable(app: Application, ref: str) -> None:
    """Wait until a component is READY."""
    asked = {"query_type": "component_status", "condition": f"component_ref = '{ref}'"}
    async with asyncio.timeout(60):
        while not any(each["value"] == "READY" for each in (await app.ask("rois.query.query", **asked))["results"]):
            pass


async def statuses(app: Application, count: int) -> set[tuple[str, str]]:
    told = [await app.next(STATUS) for _ in range(count)]
    return {(each["stream_id"], each["status"].removeprefix("STREAMING_")) for each in told}


@pytest.mark.parametrize("engine", ENGINES)
async def test_pictures_and_sound_come_straight_from_the_game_engine(engine: str) -> None:
    async with (
        house(engine, ice_servers=("stun:127.0.0.1:9",)) as here,
        application(here.gateway) as app,
        streaming(ENGINES[engine], here.avatar.url) as played,
    ):
        video, audio = await both_connected(app)
        async with MeasuringSink() as sink:
            offer = await answered(app, sink)
            assert {each.stream_id for each in offer.streams} == {video, audio}
            assert (await statuses(app, 1)).pop()[1] == "NOT_CONNECTED"
            assert await statuses(app, 2) == {(video, "RUNNING"), (audio, "RUNNING")}
            await sink.sees(20)
            assert sink.pictures().unreadable == 0
            await sink.hears(1)

            for verb in ("suspend_stream", "resume_stream"):
                for stream in (video, audio):
                    assert await app.code(f"rois.stream.{verb}", stream_id=stream) == "OK"
                if verb == "suspend_stream":
                    assert await statuses(app, 2) == {(video, "SUSPENDED"), (audio, "SUSPENDED")}
                    await played.until(lambda: not played.sessions)
        async with MeasuringSink() as sink:
            again = await answered(app, sink)
            assert again.replaces == offer.peer_id
            assert await statuses(app, 4) == {
                (each, what) for each in (video, audio) for what in ("RESUMED", "RUNNING")
            }
            await sink.sees(5)
        if engine == "unreal":
            told = played.told("config")[-1]["peerConnectionOptions"]
            assert told == {"iceServers": [{"urls": ["stun:127.0.0.1:9"]}]}


async def test_a_game_engine_that_goes_and_comes_back() -> None:
    async with house("unreal") as here, application(here.gateway) as app:
        code, why = await app.why("rois.stream.connect_stream", component_ref=VIDEO)
        assert (code, why) == ("ERROR", "no game engine is connected to this adapter's signaling server")
        async with streaming(FakeUnreal, here.avatar.url), MeasuringSink() as sink:
            await app.eventually("OK", "rois.stream.connect_stream", component_ref=VIDEO)
            assert await app.code("rois.stream.connect_stream", component_ref=VIDEO) == "OUT_OF_RESOURCES"
            first = Offer.model_validate(await app.next("signaling.offer"))
            # The answer of a sink takes all that is offered, and the sound was not connected.
            taken = await sink.respond(first)
            assert await app.code("signaling.answer", **taken.wire()) == "BAD_PARAMETER"
            assert "was not connected" in (await app.next("signaling.bye"))["reason"]
            await connected(app, VIDEO)
            second = Offer.model_validate(await app.next("signaling.offer"))
        assert await app.next("signaling.bye") == {"peer_id": second.peer_id, "reason": "the game engine is gone"}
        code, why = await app.why("rois.stream.connect_stream", component_ref=VIDEO)
        assert (code, why) == ("ERROR", "the game engine is gone: it has closed the connection")
        async with streaming(FakeUnreal, here.avatar.url):
            await app.eventually("OK", "rois.stream.connect_stream", component_ref=VIDEO)
            await app.next("signaling.offer")
        status = await app.ask("rois.system.get_profile")
        assert status["return_code"] == "OK"


async def test_streams_belong_to_the_client_that_connected_them() -> None:
    async with (
        house("unreal") as here,
        application(here.gateway) as app,
        application(here.gateway) as other,
        streaming(FakeUnreal, here.avatar.url),
    ):
        await app.eventually("OK", "rois.stream.connect_stream", component_ref=VIDEO)
        offer = await app.next("signaling.offer")
        stream = offer["streams"][0]["stream_id"]
        for verb in ("suspend_stream", "resume_stream", "disconnect_stream", "query_stream_status"):
            assert await other.code(f"rois.stream.{verb}", stream_id=stream) == "UNSUPPORTED"
        assert await other.code("signaling.restart", peer_id=offer["peer_id"]) == "UNSUPPORTED"
        assert await app.code("signaling.restart", peer_id=offer["peer_id"]) == "OK"
        found = {"peer_id": offer["peer_id"], "generation": 1, "candidate": "candidate:x", "sdp_mid": "0"}
        assert await app.code("signaling.candidate", **found) == "OK"
        assert await other.code("signaling.candidate", **found) == "UNSUPPORTED"
        assert (await here.avatar.collect_figures()).process.sessions == 1
        sends = {"name": "transport_parameters", "data_type_ref": "string", "value": '{"direction": "sendonly"}'}
        code, why = await app.why("rois.stream.connect_stream", component_ref=AUDIO, parameters=[sends])
        assert (code, "recvonly" in why) == ("UNSUPPORTED", True)
        assert await app.code("rois.stream.disconnect_stream", stream_id=stream) == "OK"
        assert (await app.next("signaling.bye"))["reason"] == "no stream is left to play"


async def test_commands_go_over_the_engine_link_beside(tmp_path: Path) -> None:
    link = f"unix:{tmp_path}/engine"
    async with house("unreal", link) as here, application(here.gateway) as app:
        plugin = await asyncio.to_thread(LinkClient.connect, link, HELLO)
        try:
            # A plug-in without pictures has paused them for good.
            plugin.send_event(Pause(True))
            await usable(app, REACTION)
            assert await app.code("rois.command.bind", component_ref=REACTION) == "OK"
            nod = {"name": "reaction_ref", "data_type_ref": "RoIS_Identifier", "value": NOD}
            assert await app.code("rois.command.set_parameter", component_ref=REACTION, parameters=[nod]) == "OK"
            unit = {"component_ref": REACTION, "command_type": "start", "command_id": "n", "arguments": []}
            assert await app.code("rois.command.execute", command_unit_list=[unit]) == "OK"
            (command,) = await asyncio.to_thread(plugin.poll_commands, 5)
            assert isinstance(command, React)
            plugin.send_event(Completed(command.id, "OK"))
            told = await app.next("rois.command.completed")
            while told["command_id"] != "n":
                told = await app.next("rois.command.completed")
            assert told["status"] == "OK"
        finally:
            await asyncio.to_thread(plugin.close, "done")
