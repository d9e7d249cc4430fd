"""What is urgent, what that overtakes, and what is answered when there are too many."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.interfaces.overload_rules import MAX_UNITS, MOST_UNITS, is_urgent, meant, named, queue_rules, refusal
from openrois.jsonrpc import request_queue
from openrois.jsonrpc.protocol import Request
from openrois.types.messages import ResultsResult


def execute(*units: Any) -> Request:
    return Request(1, "rois.command.execute", {"command_unit_list": list(units)})


def unit(command_type: str, ref: str = "robot/base") -> dict[str, Any]:
    return {"component_ref": ref, "command_type": command_type, "command_id": "c"}


STOP = unit("stop")
BOTH = {"command_list": [STOP, unit("stop", "robot/arm")]}


@pytest.mark.parametrize(
    ("request_", "urgent"),
    [
        (Request(1, "rois.command.release", {"component_ref": "robot/base"}), True),
        (Request(1, "rois.system.disconnect", {}), True),
        (Request(1, "openrois.stop_all", {}), True),
        (Request(1, "rois.command.bind", {"component_ref": "robot/base"}), False),
        (execute(STOP), True),
        (execute(STOP, BOTH), True),
        (execute(*[STOP] * (MAX_UNITS + 1)), False),
        (execute(STOP, unit("start")), False),
        (execute({"command_list": [STOP, unit("start")]}), False),
        (execute({"command_list": []}), False),
        (execute(), False),
        (execute(5), False),
        (Request(1, "rois.command.execute", [STOP]), False),
        (Request(1, "rois.command.execute", {"command_unit_list": STOP}), False),
    ],
)
def test_what_is_urgent(request_: Request, urgent: bool) -> None:
    assert is_urgent(request_) is urgent


@pytest.mark.parametrize(
    ("urgent", "waiting", "overtaken"),
    [
        (execute(STOP), execute(unit("start")), True),
        (execute(STOP), execute(unit("start", "robot/arm")), False),
        (execute(BOTH), execute(unit("start", "robot/arm")), True),
        (execute(STOP), Request(2, "rois.command.set_parameter", {"component_ref": "robot/base"}), True),
        (execute(STOP), Request(2, "rois.command.bind_any", {"condition": ""}), True),
        (execute(STOP), Request(2, "rois.query.query", {"query_type": "x"}), False),
        (Request(1, "openrois.stop_all", {}), execute(unit("start")), True),
        (Request(1, "rois.system.disconnect", {}), Request(2, "rois.command.bind", {"component_ref": "x/y"}), True),
        (Request(1, "rois.command.release", {"component_ref": "x/y"}), execute(STOP), False),
    ],
)
def test_what_it_overtakes(urgent: Request, waiting: Request, overtaken: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(request_queue, "MAX_RUNNING_REQUESTS", 0)
    refused: list[Request] = []
    waits = request_queue.RequestQueue(
        lambda *_started: None, lambda request, _reason: refused.append(request), queue_rules()
    )
    waits.put_request(waiting, 1)
    waits.put_request(urgent, 1)
    assert refused == [waiting] * overtaken


def test_a_request_of_very_many_commands_may_be_about_anything() -> None:
    assert meant(execute(*[STOP] * MOST_UNITS)) == {"robot/base"}
    assert meant(execute(*[STOP] * (MOST_UNITS + 1))) == frozenset()


json = st.recursive(
    st.none() | st.integers() | st.sampled_from(["stop", "robot/base"]),
    lambda inner: (
        st.lists(inner)
        | st.dictionaries(
            st.sampled_from(["command_unit_list", "command_list", "component_ref", "command_type"]), inner
        )
    ),
)


@settings(max_examples=50)
@given(json, json)
def test_params_of_any_kind_are_looked_at(one: Any, other: Any) -> None:
    for method in ("rois.command.execute", "rois.command.release"):
        request = Request(1, method, one)
        assert is_urgent(request) in (True, False)
        assert isinstance(meant(request), frozenset)
        assert isinstance(named(Request(2, "rois.command.execute", other)), frozenset)


def test_the_answer_is_that_of_the_method() -> None:
    result = refusal("rois.query.query")
    assert isinstance(result, ResultsResult)
    assert result.return_code == "OUT_OF_RESOURCES"
    assert refusal("unknown.method") is None
