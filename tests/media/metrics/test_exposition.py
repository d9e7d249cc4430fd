from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import pytest
from openrois_body.metrics import INPUT, SENSE, SPEECH, SPEECHES, body_figures
from openrois_body.sensing.figures import SenseFigures
from openrois_body.speech.speech_control import SpeechFigures, SpeechOutcomes
from openrois_body.teleoperation.operator_control import OperatorFigures
from openrois_media.metrics import exposition
from openrois_media.metrics.exposition import written
from openrois_media.metrics.figures import (
    ADAPTATION,
    ADAPTER,
    GUARD,
    RECEPTION,
    RENDITION,
    SOURCE,
    STATUSES,
    STREAM,
    VISITORS,
    Process,
    Snapshot,
    Source,
)
from openrois_media.visitors.figures import VisitorFigures
from openrois_media.visitors.registry import MAX_VISITORS
from openrois_streaming.publish.rendition import RenditionFigures
from openrois_streaming.state import StreamStatus
from openrois_streaming.stats import AdaptationStats, ReceiverFigures, StreamStats
from prometheus_client import Metric
from prometheus_client.openmetrics.parser import text_string_to_metric_families as read_open_metrics
from prometheus_client.parser import text_string_to_metric_families

from openrois.metrics.figure import Figure
from openrois.types.codes import ComponentStatus

STREAM_1 = StreamStats(
    stream_id="avatar/1",
    component_ref="avatar/video_streaming",
    kind="video",
    status=StreamStatus.RUNNING,
    codec="video/H264",
    frames_sent=10,
    frames_dropped=2,
    key_frames=1,
    bytes_sent=5000,
    key_frame_requests=3,
    packets_sent=40,
    packets_retransmitted=5,
    retransmissions_refused=1,
    frames_received=7,
    path_bitrate=2_000_000,
    round_trip_time=0.02,
    packets_lost=4,
    fraction_lost=0.25,
    jitter=0.001,
    playout_delay=0.15,
    adaptation=AdaptationStats(640, 360, 30.0, 900_000, 1_100_000, 2_000_000, False, 3),
    reception=ReceiverFigures(90, 9000, 6, 2, 1, 1, 30, 8, 0.004, 0.03, 1.5),
)
RENDITION_1 = RenditionFigures("video/H264", True, 1, 1_500_000, 11, 5500, 2, 1, 1, 5, 0.5)
SNAPSHOT = Snapshot(
    Process(1, 64, 20, 5),
    (Source("engine", ComponentStatus.READY, 12, 0.01, 2), Source("sound", ComponentStatus.WARNING, 0, None)),
    (("picture", RENDITION_1),),
    (STREAM_1,),
    (("strangers", 3), ("malformed", 0)),
    body_figures(
        {"vision": SenseFigures(40, 2, None, 1.5), "hearing": SenseFigures(3, 0, 1, 0.5)},
        OperatorFigures(9, 1),
        SpeechFigures(50, 2),
        SpeechOutcomes(begun=4, cut=1),
    ),
    visitors=VisitorFigures(present=3, refused=2, relayed=1),
)
FIGURES: tuple[Figure[Any], ...] = (
    *ADAPTER,
    *GUARD,
    *SENSE,
    *INPUT,
    *SPEECH,
    *SPEECHES,
    *VISITORS,
    *SOURCE,
    *RENDITION,
    *STREAM,
    *ADAPTATION,
    *RECEPTION,
)


def samples(families: Iterable[Metric]) -> dict[str, dict[tuple[str, ...], float]]:
    """Values by the name of the sample and the values of its labels, in the order of the labels' names."""
    found: dict[str, dict[tuple[str, ...], float]] = {}
    for family in families:
        for sample in family.samples:
            found.setdefault(sample.name, {})[tuple(value for _, value in sorted(sample.labels.items()))] = sample.value
    return found


def scraped(snapshot: Snapshot) -> dict[str, dict[tuple[str, ...], float]]:
    text, content_type = written(snapshot)
    assert content_type.startswith("text/plain")
    return samples(text_string_to_metric_families(text.decode()))


def test_every_figure_of_a_stream_a_rendition_and_a_source_is_there() -> None:
    found = scraped(SNAPSHOT)
    assert {figure.name for figure in FIGURES} | set(STATUSES) <= set(found)
    labels = ("video/H264", "avatar/video_streaming", "video", "avatar/1")
    assert found["openrois_stream_frames_total"] == {labels: 10}
    assert found["openrois_stream_loss_ratio"] == {labels: 0.25}
    assert found["openrois_rendition_encoder_seconds_total"] == {("video/H264", "", "picture"): 0.5}
    assert found["openrois_stream_height_pixels"] == {labels: 360}
    assert found["openrois_stream_usable_bits_per_second"] == {labels: 1_100_000}
    assert found["openrois_stream_received_lost_packets"] == {labels: 6}
    assert found["openrois_stream_playout_delay_seconds"] == {labels: 0.03}
    assert found["openrois_stream_concealed_seconds_total"] == {labels: 1.5}
    assert found["openrois_sessions_limit"] == {(): 64}
    assert found["openrois_guard_dropped_datagrams_total"] == {("strangers",): 3, ("malformed",): 0}
    assert found["openrois_sense_analysed_total"] == {("vision",): 40, ("hearing",): 3}
    assert found["openrois_sense_lost_total"] == {("hearing",): 1}
    assert found["openrois_sense_analysis_seconds_total"][("vision",)] == 1.5
    assert found["openrois_speech_frames_total"] == {
        ("taken",): 50,
        ("dropped",): 2,
        ("refused",): 0,
        ("malformed",): 0,
    }
    assert found["openrois_speeches_total"] == {("begun",): 4, ("starved",): 0, ("finished",): 0, ("cut",): 1}
    assert [found[f"openrois_{name}"] for name in ("visitors", "visitors_limit", "refused_visitors_total")] == [
        {(): 3},
        {(): MAX_VISITORS},
        {(): 2},
    ]
    assert found["openrois_relayed_streams"] == {(): 1}
    assert found["openrois_input_messages_total"] == {
        ("taken",): 9,
        ("refused",): 1,
        ("malformed",): 0,
        ("dropped",): 0,
    }
    assert found["openrois_source_last_frame_age_seconds"] == {("engine",): 0.01}
    assert found["openrois_source_encoders"] == {("engine",): 2}
    states = {values[3]: value for values, value in found["openrois_stream_status"].items()}
    assert states == {"not_connected": 0, "not_running": 0, "running": 1, "suspended": 0}
    assert found["openrois_source_status"][("warning", "sound")] == 1
    assert found["process_cpu_seconds_total"][()] > 0


async def test_a_scrape_takes_a_snapshot() -> None:
    async def look() -> Snapshot:
        return SNAPSHOT

    assert (await exposition.scraped(look, ""))[0].count(b"openrois_") == written(SNAPSHOT)[0].count(b"openrois_")


def test_nothing_is_left_of_a_stream_that_has_ended() -> None:
    assert "avatar/1" in written(SNAPSHOT)[0].decode()
    assert "avatar/1" not in written(replace(SNAPSHOT, streams=()))[0].decode()


def test_unreported_figures_are_left_out() -> None:
    silent = replace(
        STREAM_1,
        codec=None,
        path_bitrate=None,
        round_trip_time=None,
        packets_lost=None,
        fraction_lost=None,
        jitter=None,
    )
    silent = replace(silent, adaptation=None, reception=None)
    found = scraped(replace(SNAPSHOT, streams=(silent,)))
    assert {
        "openrois_stream_round_trip_seconds",
        "openrois_stream_height_pixels",
        "openrois_stream_received_packets_total",
    }.isdisjoint(found)
    assert found["openrois_stream_frames_total"] == {("", "avatar/video_streaming", "video", "avatar/1"): 10}


def test_open_metrics_are_served_when_preferred() -> None:
    text, content_type = written(SNAPSHOT, "application/openmetrics-text; version=1.0.0")
    assert content_type.startswith("application/openmetrics-text")
    found = samples(read_open_metrics(text.decode()))  # type: ignore[no-untyped-call]
    assert {figure.name for figure in FIGURES} <= set(found)


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.name)
def test_names_follow_the_conventions(figure: object) -> None:
    name, kind = getattr(figure, "name"), getattr(figure, "kind")  # noqa: B009
    assert name.startswith("openrois_")
    assert name.endswith("_total") is (kind == "counter")
