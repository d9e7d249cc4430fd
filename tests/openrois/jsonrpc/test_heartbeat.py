"""The adapter's end of the line to its gateway."""

from openrois.jsonrpc.heartbeat import Heartbeat
from tests.support.clock import Clock


def test_signs_are_asked_for_while_they_are_wanted() -> None:
    clock, asked, cuts = Clock(), list[bool](), list[str]()
    line = Heartbeat(clock)
    line.on_cut.add(cuts.append)
    line.want(True)
    assert not line.is_alive
    clock.now = 5
    line.attach(asked.append)
    assert (line.is_alive, line.seen_at, asked) == (True, 5, [True])
    clock.now = 6
    line.sign()
    line.want(True)
    line.want(False)
    line.cut("gone")
    line.want(True)
    assert (line.is_alive, line.seen_at, asked, cuts) == (False, 6, [True, False], ["gone"])
    line.want(False)
    line.attach(asked.append)
    assert asked == [True, False]
