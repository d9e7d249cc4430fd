"""What is recorded of a flood of refusals."""

from openrois.gateway import admission
from openrois.gateway.audit_rate import AuditRate
from tests.support.clock import Clock


def note(flood: AuditRate, reason: str) -> str | None:
    return flood.told(reason) if flood.admits() else None


def test_of_what_is_left_out_the_number_is_told() -> None:
    clock = Clock()
    flood = AuditRate(admission.REFUSED_AT_ONCE, admission.REFUSED_PER_SECOND, clock)
    assert [note(flood, "missing") for _ in range(admission.REFUSED_AT_ONCE)][-1] == "missing"
    assert [note(flood, "missing") for _ in range(5)] == [None] * 5
    clock.now += 1
    assert note(flood, "host") == "host (and 5 more refusals before)"
    assert note(flood, "host") == "host"
