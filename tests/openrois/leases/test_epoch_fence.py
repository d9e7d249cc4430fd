"""Two gateways that both claim one adapter."""

from openrois.leases.epoch_fence import EpochFence


def test_the_later_holder_wins() -> None:
    fence = EpochFence()
    assert fence.admits("old", "r/arm")
    assert fence.note("old", "r/arm", 5)
    assert fence.note("new", "r/arm", 7)
    assert (fence.admits("old", "r/arm"), fence.admits("new", "r/arm")) == (False, True)
    assert not fence.note("old", "r/arm", 6)
    assert not fence.note("new", "r/arm", 3)
    assert fence.admits("new", "r/arm")
    assert fence.admits("old", "r/lamp")
    fence.forget_parent("new")
    fence.forget_parent("unknown")
    assert fence.admits("old", "r/arm")
