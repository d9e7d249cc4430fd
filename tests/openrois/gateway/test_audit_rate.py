"""What is recorded of a flood of refusals."""

from openrois.gateway import admission
from openrois.gateway.audit_rate import AuditRate
from tests.support.clock import Clock


def note(audit_rate: AuditRate, reason: str) -> str | None:
    return audit_rate.told(reason) if audit_rate.admits() else None


def test_of_what_is_left_out_the_number_is_told() -> None:
    clock = Clock()
    audit_rate = AuditRate(admission.REFUSED_AT_ONCE, admission.REFUSED_PER_SECOND, clock)
    assert [note(audit_rate, "missing") for _ in range(admission.REFUSED_AT_ONCE)][-1] == "missing"
    assert [note(audit_rate, "missing") for _ in range(5)] == [None] * 5
    clock.now += 1
    assert note(audit_rate, "host") == "host (and 5 more refusals before)"
    assert note(audit_rate, "host") == "host"
