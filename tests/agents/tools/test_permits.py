"""What a task may do with its body."""

import pytest
from openrois_agents.tools.permits import Permits

from openrois.errors import OutOfResources, Unsupported

pytestmark = pytest.mark.extra(name="mcp")


def test_a_tool_that_was_not_named_is_refused() -> None:
    permits = Permits(frozenset({"say", "gesture"}), 30, lambda: 0.0)
    permits.require("say")
    with pytest.raises(Unsupported, match="go_to is not allowed in this task, which has gesture, say: give_back, then"):
        permits.require("go_to")


def test_movements_come_back_with_time() -> None:
    now = [0.0]
    permits = Permits(frozenset(), 6, lambda: now[0])
    for _ in range(6):
        permits.count_movement()
    with pytest.raises(OutOfResources, match="more than 6 movements a minute: try again in 10 s"):
        permits.count_movement()
    now[0] = 10.0
    permits.count_movement()
