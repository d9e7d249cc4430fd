"""Models of the extensions."""

import pytest
from pydantic import ValidationError

from openrois.types.codes import StreamStatus
from openrois.types.streams import (
    EXTENSIONS,
    STREAM_METHODS,
    ConnectStreamParams,
    HelloParams,
    HelloResult,
    StreamStatusNotification,
    StreamStatusResult,
    subject_of,
)


def test_hello() -> None:
    assert HelloParams.model_validate({"version": "1"}).extensions == ()
    assert HelloResult(client_id="c", extensions=EXTENSIONS, engines=("robot",)).model_dump(mode="json") == {
        "return_code": "OK",
        "version": "1",
        "extensions": list(EXTENSIONS),
        "engines": ["robot"],
        "client_id": "c",
        "instance": "",
        "epoch": 0,
        "stopped": [],
    }
    with pytest.raises(ValidationError):
        HelloParams.model_validate({"version": "1", "extensions": ["x"] * 65})
    for wrong in ({"instance": "x" * 65}, {"epoch": -1}):
        with pytest.raises(ValidationError):
            HelloResult.model_validate(wrong)


def test_every_verb_has_its_method() -> None:
    assert all(name == f"rois.stream.{verb}" for verb, name in STREAM_METHODS.items())


def test_connect_stream_may_leave_its_parameters_out() -> None:
    assert ConnectStreamParams.model_validate({"component_ref": "a/v"}).parameters == ()
    with pytest.raises(ValidationError):
        ConnectStreamParams.model_validate({"component_ref": "a/v", "client_id": "x"})


def test_a_failed_status_query_says_not_connected() -> None:
    assert StreamStatusResult().status is StreamStatus.STREAMING_NOT_CONNECTED


def test_a_status_notification_survives_the_wire() -> None:
    params = {"stream_id": "a/1", "component_ref": "a/v", "status": "STREAMING_RESUMED", "timestamp": "t"}
    notice = StreamStatusNotification.model_validate(params)
    assert notice.model_dump(mode="json") == params
    assert StreamStatusNotification.method == "rois.stream.notify_stream_status"


@pytest.mark.parametrize(
    ("params", "subject"),
    [
        ({"component_ref": "robot/eye"}, "robot/eye"),
        ({"stream_id": "robot/1", "client_id": "c"}, "robot/1"),
        ({"peer_id": "robot/2"}, "robot/2"),
        ({"stream_id": 5}, ""),
        ({}, ""),
    ],
)
def test_what_a_message_is_about(params: dict[str, object], subject: str) -> None:
    assert subject_of(params) == subject
