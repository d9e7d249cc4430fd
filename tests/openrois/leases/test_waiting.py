"""The queue for a component."""

from openrois.leases.waiting import Request, Waiting


def test_first_come_first_in_line() -> None:
    waiting = Waiting()
    assert waiting.count() == 0
    ann, bob = Request("1", "r/lamp", "r/lamp", "ann", None), Request("2", "r/lamp", "r/lamp", "bob", 5.0)
    waiting.add(ann)
    waiting.add(bob)
    assert waiting.queue("r/lamp") == (ann, bob)
    assert (waiting.get("2"), waiting.get("3")) == (bob, None)
    assert (waiting.find("r/lamp", "bob"), waiting.find("r/arm", "bob")) == (bob, None)
    assert (waiting.of("ann"), waiting.unanswered()) == ((ann,), (bob,))
    waiting.remove(ann)
    waiting.remove(bob)
    assert (waiting.queue("r/lamp"), waiting.of("bob")) == ((), ())
