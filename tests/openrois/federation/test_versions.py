"""What a minor release keeps for gateways of the one before: whatever may be missing there is required by none here."""

from typing import Any

import pytest
from pydantic import BaseModel

from openrois.cluster.frames import PROTOCOL, Accept, Address, Beat, Dial, parse_said
from openrois.cluster.postgres.schema import STEPS
from openrois.cluster.postgres.stop_messages import StopAsked, StopTold, read_message
from openrois.federation.assertion import Assertion
from openrois.federation.shared_quotas import _Told
from openrois.gateway.applications import ResumeReportParams
from openrois.types.leases import ResumeResult, StopAllResult
from openrois.types.stops import Stopped, StoppedNotification
from openrois.types.streams import HelloParams, HelloResult, HolderNotification

REQUIRED: dict[type[BaseModel], set[str]] = {
    Address: {"link", "stream"},
    Accept: {"link", "stream", "window"},
    Dial: {"link", "stream", "window", "gateway", "hello"},
    Beat: {"gateway", "instance", "link", "version"},
    Assertion: {"kind", "subject"},
    StopAsked: {"id", "asker", "owner", "engine_id", "subject"},
    StopTold: {"id", "asker", "owner", "part", "parts"},
    _Told: {"gateway", "used"},
    ResumeReportParams: set(),
    ResumeResult: set(),
    StopAllResult: set(),
    HelloParams: {"version"},
    HelloResult: set(),
    HolderNotification: {"component_ref", "holds", "epoch"},
    StoppedNotification: {"engine_id"},
    Stopped: {"engine_id", "by"},
}
"""What is required of messages between gateways, and between them and adapters, since 0.2."""


@pytest.mark.parametrize("model", REQUIRED, ids=lambda model: model.__name__)
def test_nothing_more_is_required_than_the_release_before_says(model: type[BaseModel]) -> None:
    required = {name for name, field in model.model_fields.items() if field.is_required()}
    assert required == REQUIRED[model]


def test_frames_are_those_of_the_release_before() -> None:
    assert PROTOCOL == 1


def test_tables_go_on_by_one_version_with_a_minor_release() -> None:
    # 0.2 has version 3; the next minor release has 3 or 4.
    assert len(STEPS) in (3, 4)


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (Dial, {"link": "0" * 16, "stream": 1, "window": 1 << 20, "gateway": "b", "hello": {"kind": "local"}}),
        (Beat, {"gateway": "b", "instance": "0" * 16, "link": "1" * 16, "version": "0.3.0"}),
    ],
)
def test_what_a_newer_gateway_says_over_nats_besides_is_passed_over(model: Any, said: dict[str, Any]) -> None:
    text = model(**said).model_dump_json().replace("{", '{"more": [1], ', 1)
    assert parse_said(model, text.encode()) == model(**said)


def test_what_a_newer_gateway_says_over_the_store_besides_is_passed_over() -> None:
    asked = StopAsked(id="0" * 32, asker="a", owner="b", engine_id="robot", subject="ann")
    text = asked.model_dump_json().replace("{", '{"more": {"a": 1}, ', 1)
    assert read_message(f"asked {text}") == asked
