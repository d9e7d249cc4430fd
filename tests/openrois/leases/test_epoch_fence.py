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


def test_the_greatest_epochs_stay_when_their_parent_has_gone() -> None:
    fence = EpochFence()
    assert fence.greatest == 0
    assert fence.note("old", "r/arm", 5)
    assert fence.note("new", "r/arm", 7)
    assert fence.note("new", "r/lamp", 8)
    fence.forget_parent("new")
    fence.forget_parent("unknown")
    assert not fence.admits("old", "r/arm")
    assert not fence.note("third", "r/arm", 6)
    assert fence.note("third", "r/arm", 7)
    assert fence.greatest == 8


def test_a_parent_that_has_gone_is_not_judged_by_what_it_reported() -> None:
    fence = EpochFence()
    fence.note("old", "r/arm", 5)
    fence.note("new", "r/arm", 7)
    fence.forget_parent("old")
    assert fence.admits("old", "r/arm")
