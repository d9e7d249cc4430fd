"""Whether a claim is granted or has to wait, and which epochs it reserves."""

import pytest

from openrois.errors import BadParameter
from openrois.ownership.claims import Owner
from openrois.ownership.rules import BLOCK, MAX_EPOCH, Granted, Reading, Record, Waiting, judge_claim

pytestmark = pytest.mark.extra(name="base")

NOW = 1_900_000_000_000
TTL = 10_000


def reading(record: Record | None, *, left: int = 5_000) -> Reading:
    return Reading(record, NOW + left if record is not None else 0, TTL if record is not None else 0, 1, NOW, NOW)


def owned(first_epoch: int = NOW - 1000, gateway_id: str = "a") -> Record:
    return Record("kachaka", gateway_id, "one" if gateway_id else "", first_epoch)


@pytest.mark.parametrize("record", [None, owned(gateway_id="")])
def test_an_engine_without_an_owner_is_granted(record: Record | None) -> None:
    assert isinstance(judge_claim(reading(record), "two", 0, 0.0), Granted)


def test_the_same_adapter_is_granted_whatever_the_owner_does() -> None:
    assert judge_claim(reading(owned()), "one", 0, 0.0) == Granted(NOW - 1000 + BLOCK, None)


@pytest.mark.parametrize(("left", "contact", "seconds"), [(5_000, 60.0, 5.0), (-20_000, 4.0, 6.0), (7_000, 9.0, 7.0)])
def test_another_adapter_waits_for_the_expiry_and_for_lasting_contact(
    left: int, contact: float, seconds: float
) -> None:
    assert judge_claim(reading(owned(), left=left), "two", 0, contact) == Waiting("a", seconds)


def test_an_expired_claim_is_granted_as_long_as_its_owner_does_not_renew() -> None:
    assert judge_claim(reading(owned(), left=0), "two", 0, 10.0) == Granted(NOW - 1000 + BLOCK, NOW)


def test_an_owner_that_the_store_does_not_know_is_not_waited_for() -> None:
    unknown = Reading(owned(), 0, 0, 1, NOW, NOW)
    assert judge_claim(unknown, "two", 0, 0.0) == Granted(NOW - 1000 + BLOCK, None)


@pytest.mark.parametrize(
    ("stored", "above", "first"),
    [
        (0, 0, NOW),
        (NOW - BLOCK, 0, NOW),
        (NOW + 7, 0, NOW + 7 + BLOCK),
        (NOW + 7, NOW + 7 + BLOCK - 1, NOW + 7 + 2 * BLOCK - 1),
        (NOW - 9 * BLOCK, NOW + 100, NOW + 100 + BLOCK),
    ],
)
def test_a_block_is_behind_what_is_stored_the_clock_and_what_the_adapter_has_seen(
    stored: int, above: int, first: int
) -> None:
    ruling = judge_claim(reading(owned(stored)), "one", above, 0.0)
    assert isinstance(ruling, Granted)
    assert ruling.first_epoch == first


def test_the_last_block_ends_with_the_greatest_epoch() -> None:
    last = MAX_EPOCH - 2 * BLOCK + 1
    assert judge_claim(reading(None), "one", last, 0.0) == Granted(MAX_EPOCH - BLOCK + 1, None)
    with pytest.raises(BadParameter, match=f"no epochs left behind {last + 1}, which no gateway has given"):
        judge_claim(reading(None), "one", last + 1, 0.0)


def test_a_record_names_the_owner_unless_it_was_released() -> None:
    assert owned().owner == Owner("kachaka", "a", "one", NOW - 1000)
    assert owned(gateway_id="").owner is None
