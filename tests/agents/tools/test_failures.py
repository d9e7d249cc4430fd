"""What an agent is told when a tool fails."""

import logging

import pytest
from openrois_agents.tools.failures import failure

from openrois.client import Aborted, BadParameter, ConnectionFailed, ConnectionLost, OutOfResources, RpcError, TimedOut
from openrois.extras import MissingExtra

pytestmark = pytest.mark.extra(name="mcp")


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (BadParameter("no such name"), "BadParameter: no such name"),
        (OutOfResources("robot was\nstopped by ann"), "OutOfResources: robot was stopped by ann"),
        (Aborted("start ended ABORT"), "Aborted: start ended ABORT"),
        (TimedOut("too slow"), "TimedOut: too slow"),
        (TimeoutError(), "TimedOut: no answer came in time"),
        (ConnectionFailed("nothing listens"), "ConnectionLost: nothing listens"),
        (ConnectionLost("it ended"), "ConnectionLost: it ended"),
        (MissingExtra("cv2 is not installed"), "Unsupported: cv2 is not installed"),
        (RpcError(-32601, "Method not found"), "Unsupported: "),
        (ValueError("no pictures"), "BadParameter: no pictures"),
    ],
)
def test_a_reason_is_told(error: Exception, said: str, caplog: pytest.LogCaptureFixture) -> None:
    kind, sentence = failure("say", error)
    assert sentence.startswith(said)
    assert sentence.startswith(f"{kind}: ")
    assert caplog.records == []


def test_a_bug_is_logged_and_not_told(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR):
        kind, sentence = failure("say", ZeroDivisionError("/srv/secret"))
    assert (kind, "secret" in sentence) == ("Error", False)
    assert "the tool say failed" in caplog.text


def test_a_long_reason_for_an_agent_is_cut() -> None:
    assert len(failure("say", BadParameter("x" * 5_000))[1]) <= 1_100
