"""What `docs/reference/wire.md` promises, seen by an application that was written from it alone."""

import itertools
import json
import subprocess
import sys
from collections.abc import AsyncIterator

import pytest

from tests.support.black_box import (
    AUDIO,
    H264,
    STATUS,
    VIDEO,
    Application,
    Message,
    application,
)
from tests.support.black_box_media import MARKER_HZ, SAMPLE_RATE, bursts, pitch
from tests.support.demo import Demo

pytestmark = pytest.mark.media


@pytest.fixture
async def app(demo: Demo) -> AsyncIterator[Application]:
    async with application(demo.url) as connected:
        await connected.hello()
        yield connected


def test_the_client_imports_nothing_of_this_project() -> None:
    script = "import sys, tests.support.black_box; print([name for name in sys.modules if 'openrois' in name])"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=20, check=True)
    assert run.stdout == "[]\n"


async def test_components_can_be_found(app: Application) -> None:
    found = await app.ask(
        "rois.command.search", condition="component_type = 'urn:x-rois:def:component:OMG::VideoStreaming'"
    )
    assert found == {"return_code": "OK", "component_ref_list": [VIDEO]}
    profile = await app.ask("rois.system.get_profile")
    assert {VIDEO, AUDIO} <= set(profile["component_profiles"])


async def test_pictures_and_sound_arrive_in_order_and_on_time(app: Application) -> None:
    video, audio = await app.connect_stream(VIDEO, H264), await app.connect_stream(AUDIO)
    await app.until_status(video, "RUNNING")
    await app.until_status(audio, "RUNNING")
    assert app.statuses(video) == app.statuses(audio) == ["NOT_RUNNING", "RUNNING"]
    assert await app.status(video) == await app.status(audio) == "STREAMING_RUNNING"

    pictures = await app.pictures(video, 60)
    assert all(earlier.number < later.number for earlier, later in itertools.pairwise(pictures))
    assert pictures[-1].number - pictures[0].number < 90, "more than a third was lost"
    assert all(-0.05 < picture.age < 1 for picture in pictures)
    # A machine that stands still for a moment loses datagrams even on the loopback.
    assert app.media(video).unreadable == 0 or await app.packets_lost(video)

    await app.news.until(lambda: app.media(audio).blocks >= 200)
    sound = app.media(audio).sound()
    # The first may have begun before its viewer came.
    _, (first, length), (second, _), *_ = bursts(sound)
    assert length == pytest.approx(0.05, abs=0.02)
    assert second - first == pytest.approx(1.0, abs=0.03)
    heard = sound[int(first * SAMPLE_RATE) : int((first + length) * SAMPLE_RATE)]
    assert pitch(heard) == pytest.approx(MARKER_HZ, abs=30)

    assert len(app.peers) == 1, "all streams of an application share one peer connection"
    assert app.peer_of(video).answer_codes == ["OK"] * len(app.peer_of(video).offers)


async def test_suspend_stops_the_pictures_and_resume_brings_them_back_without_an_offer(app: Application) -> None:
    audio, video = await app.play(AUDIO), await app.play(VIDEO, H264)
    media, offers = app.media(video), len(app.peer_of(video).offers)

    assert await app.act("suspend", video) == "OK"
    await app.until_status(video, "SUSPENDED")
    assert await app.status(video) == "STREAMING_SUSPENDED"
    await heard(app, audio, seconds=0.2)  # what is still on its way
    shown = len(media.pictures)
    await heard(app, audio, seconds=1)
    assert len(media.pictures) == shown
    assert media.luma is not None
    assert media.luma.mean() > 40, "the last picture is not black"

    last = media.pictures[-1]
    assert await app.act("resume", video) == "OK"
    back = await app.pictures(video, 10)
    await app.until_status(video, "RUNNING")
    assert back[0].number > last.number
    assert app.statuses(video)[-3:] == ["SUSPENDED", "RESUMED", "RUNNING"]
    assert len(app.peer_of(video).offers) == offers
    assert len(app.peers) == 1


async def test_a_disconnected_stream_leaves_its_section_to_the_next(app: Application) -> None:
    audio, first = await app.play(AUDIO), await app.play(VIDEO, H264)
    peer, media = app.peer_of(first), app.media(first)
    section = next(each for each in peer.offers[-1]["streams"] if each["stream_id"] == first)
    assert section == {**section, "component_ref": VIDEO, "kind": "video", "direction": "recvonly"}

    assert await app.act("disconnect", first) == "OK"
    await app.until_status(first, "NOT_CONNECTED")
    await app.news.until(lambda: peer.directions()[section["mid"]] == "inactive")
    assert [each["stream_id"] for each in peer.offers[-1]["streams"]] == [audio]
    assert (await app.ask("rois.stream.query_stream_status", stream_id=first))["return_code"] == "UNSUPPORTED"

    second = await app.play(VIDEO, H264)
    assert second != first
    assert app.peer_of(second) is peer
    assert app.media(second) is media
    assert await app.pictures(second, 5)
    assert len(peer.directions()) == 2, "no section was added"


async def test_a_restart_brings_the_same_streams_over_a_new_peer_connection(app: Application) -> None:
    stream_id = await app.play(VIDEO, H264)
    old_id, old = next(iter(app.peers.items()))
    before = app.media(stream_id)

    assert (await app.ask("signaling.restart", peer_id=old_id))["return_code"] == "OK"
    await app.news.until(lambda: len(app.peers) == 2 and app.peer_of(stream_id) is not old)
    new = app.peer_of(stream_id)
    assert new.replaces == old_id
    await app.news.until(lambda: "0" in new.media and new.media["0"].pictures)
    await app.news.until(lambda: old.bye is not None and old.connection.connectionState == "closed")
    assert new.connection.connectionState == "connected"

    assert await app.pictures(stream_id, 15)
    assert before.pictures[-1].at > new.media["0"].pictures[0].at, "the old one played until the new one did"
    assert await app.status(stream_id) == "STREAMING_RUNNING"
    assert "NOT_CONNECTED" not in app.statuses(stream_id)


async def test_a_reply_comes_before_what_it_causes(app: Application) -> None:
    stream_id = await app.play(VIDEO, H264)
    for _ in range(8):
        await app.act("suspend", stream_id)
        await app.until_status(stream_id, "SUSPENDED")
        await app.act("resume", stream_id)
        await app.until_status(stream_id, "RUNNING")
    await app.act("disconnect", stream_id)
    await app.until_status(stream_id, "NOT_CONNECTED")
    causes = {"SUSPENDED": "suspend", "RESUMED": "resume", "NOT_CONNECTED": "disconnect"}
    told: dict[str, int] = dict.fromkeys(causes.values(), 0)
    replied = dict(told)
    for name, what in app.transcript:
        if name == "reply" and what.startswith("rois.stream."):
            verb = what.removeprefix("rois.stream.").removesuffix("_stream")
            replied[verb] = replied.get(verb, 0) + 1
        elif name == STATUS and (cause := causes.get(what["status"].removeprefix("STREAMING_"))):
            told[cause] += 1
            assert told[cause] <= replied[cause], f"{what['status']} came before the reply to {cause}"
        elif name == "signaling.offer":
            assert len(what["streams"]) <= replied["connect"] - replied["disconnect"]


async def test_the_strict_form_of_rois_drives_a_stream_too(app: Application) -> None:
    chosen = {"name": "encoding_parameters", "data_type_ref": "String", "value": json.dumps({"codecs": H264})}
    answer = await app.ask("rois.command.set_parameter", component_ref=VIDEO, parameters=[chosen])
    assert await completed(app, answer["command_id"]) == "OK"
    subscribed = await app.ask(
        "rois.event.subscribe", event_type="notify_stream_status", condition=f"component_ref = '{VIDEO}'"
    )

    assert await execute(app, "connect_stream", "c1") == "OK"
    results = (await app.ask("rois.command.get_command_result", command_id="c1"))["results"]
    assert [(each["name"], each["data_type_ref"]) for each in results] == [("stream_id", "string")]
    stream_id = results[0]["value"]
    await events_told(app, subscribed["subscribe_id"], stream_id, ["NOT_RUNNING", "RUNNING"])
    assert app.peer_of(stream_id).codecs() == {"H264", "rtx"}
    assert await queried(app, stream_id) == "STREAMING_RUNNING"

    assert await execute(app, "suspend_stream", "c2", stream_id) == "OK"
    await events_told(app, subscribed["subscribe_id"], stream_id, ["SUSPENDED"])
    assert await queried(app, stream_id) == "STREAMING_SUSPENDED"
    assert await execute(app, "resume_stream", "c3", stream_id) == "OK"
    await events_told(app, subscribed["subscribe_id"], stream_id, ["RESUMED", "RUNNING"])
    assert await app.pictures(stream_id, 5)
    assert await execute(app, "disconnect_stream", "c4", stream_id) == "OK"
    events = await events_told(app, subscribed["subscribe_id"], stream_id, ["NOT_CONNECTED"])

    details = await app.ask("rois.event.get_event_detail", event_id=events[-1]["event_id"])
    assert details["results"] == events[-1]["results"]
    assert await execute(app, "suspend_stream", "c5", stream_id) == "ERROR"


async def heard(app: Application, stream_id: str, *, seconds: float) -> None:
    """Let `seconds` pass, by the sound that comes in."""
    media = app.media(stream_id)
    end = media.blocks + round(seconds * 50)
    await app.news.until(lambda: media.blocks >= end)


async def completed(app: Application, command_id: str) -> str:
    def status() -> list[str]:
        return [each["status"] for each in app.told("rois.command.completed") if each["command_id"] == command_id]

    [only] = await app.news.until(status)
    return only


async def execute(app: Application, command_type: str, command_id: str, stream_id: str | None = None) -> str:
    """Run one command to its end; returns how it was completed."""
    argument = {"name": "stream_id", "data_type_ref": "String", "value": stream_id}
    unit = {
        "component_ref": VIDEO,
        "command_type": command_type,
        "command_id": command_id,
        "arguments": [] if stream_id is None else [argument],
    }
    answer = await app.ask("rois.command.execute", command_unit_list=[unit])
    assert answer == {"return_code": "OK"}
    return await completed(app, command_id)


async def queried(app: Application, stream_id: str) -> str:
    condition = f"component_ref = '{VIDEO}' AND stream_id = '{stream_id}'"
    answer = await app.ask("rois.query.query", query_type="get_stream_status", condition=condition)
    [status] = answer["results"]
    return str(status["value"])


async def events_told(app: Application, subscribe_id: str, stream_id: str, statuses: list[str]) -> list[Message]:
    """Wait until the newest events of a subscription tell these statuses of a stream; returns all of them."""

    def events() -> list[Message]:
        return [each for each in app.told("rois.event.notify_event") if each["subscribe_id"] == subscribe_id]

    def newest() -> list[dict[str, str]]:
        return [{each["name"]: each["value"] for each in event["results"]} for event in events()][-len(statuses) :]

    wanted = [(stream_id, f"STREAMING_{status}") for status in statuses]
    await app.news.until(lambda: [(each["stream_id"], each["status"]) for each in newest()] == wanted)
    return events()
