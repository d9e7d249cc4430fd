"""Numbers of epochs: of a gateway that is alone, and of one among several."""

import pytest

from openrois.errors import OutOfResources
from openrois.leases.epochs import ClaimedEpochs, CountedEpochs

LAMP, BELL = "r/lamp", "s/bell"


class TestCounted:
    def test_one_counter_serves_all_engines(self) -> None:
        epochs = CountedEpochs(7)
        assert [epochs.next(ref) for ref in (LAMP, BELL, LAMP)] == [7, 8, 9]

    def test_an_adapter_that_has_seen_greater_ones_gets_greater_ones_still(self) -> None:
        epochs = CountedEpochs(7)
        epochs.attach("r", 100)
        epochs.attach("s", 6)
        assert [epochs.next(ref) for ref in (LAMP, LAMP, BELL)] == [101, 102, 9]
        epochs.attach("r", 101)
        assert epochs.next(LAMP) == 103
        epochs.detach("r")
        epochs.detach("unknown")
        assert epochs.next(LAMP) == 11

    def test_the_counter_goes_on_where_it_overtakes_what_was_seen(self) -> None:
        epochs = CountedEpochs(7)
        epochs.attach("r", 8)
        assert [epochs.next(ref) for ref in (BELL, BELL, BELL, LAMP)] == [7, 8, 9, 10]


class TestClaimed:
    def test_each_engine_counts_in_its_own_block(self) -> None:
        epochs = ClaimedEpochs()
        epochs.grant("r", 100, 199)
        epochs.grant("s", 500, 599)
        assert [epochs.next(ref) for ref in (LAMP, BELL, LAMP, BELL)] == [100, 500, 101, 501]

    def test_a_block_that_is_granted_again_goes_on_where_it_is(self) -> None:
        epochs = ClaimedEpochs()
        epochs.grant("r", 100, 199)
        assert epochs.next(LAMP) == 100
        epochs.detach("r")
        epochs.grant("r", 100, 199)
        assert epochs.next(LAMP) == 101
        epochs.grant("r", 300, 399)
        assert epochs.next(LAMP) == 300

    def test_what_the_adapter_has_seen_is_passed_over(self) -> None:
        epochs = ClaimedEpochs()
        epochs.grant("r", 100, 199)
        epochs.attach("r", 120)
        epochs.attach("r", 5)
        epochs.attach("unknown", 5)
        assert epochs.next(LAMP) == 121

    def test_another_block_is_asked_for_once_and_in_time(self) -> None:
        epochs, asked = ClaimedEpochs(), list[tuple[str, int, int]]()
        given = 0
        epochs.on_low = lambda engine_id, last: asked.append((engine_id, last, given))
        epochs.grant("r", 1, 101)
        for given in range(1, 102):
            assert epochs.next(LAMP) == given
        assert asked == [("r", 101, 91)]

    def test_a_block_that_the_adapter_has_seen_to_its_end_is_followed_by_another(self) -> None:
        epochs, asked = ClaimedEpochs(), list[str]()
        epochs.on_low = lambda engine_id, _last: asked.append(engine_id)
        epochs.grant("r", 1, 101)
        epochs.attach("r", 5000)
        with pytest.raises(OutOfResources, match="used up"):
            epochs.next(LAMP)
        assert asked == ["r"]

    def test_a_block_that_is_used_up_says_why_there_is_no_other(self) -> None:
        problem = "the store did not answer"
        epochs = ClaimedEpochs(lambda: problem)
        epochs.grant("r", 1, 1)
        assert epochs.next(LAMP) == epochs.used_up == 1
        with pytest.raises(OutOfResources, match=r"the epochs of r are used up .* the store did not answer"):
            epochs.next(LAMP)
        problem = ""
        with pytest.raises(OutOfResources, match="used up until it is claimed again: the claim is being made"):
            epochs.next(LAMP)
        epochs.grant("r", 2_000_002, 3_000_001)
        assert epochs.used_up == 0
        assert epochs.next(LAMP) == 2_000_002

    def test_an_engine_that_is_not_owned_has_none(self) -> None:
        epochs = ClaimedEpochs()
        epochs.grant("r", 1, 9)
        epochs.withdraw("r")
        epochs.withdraw("unknown")
        with pytest.raises(OutOfResources, match="does not own r"):
            epochs.next(LAMP)
