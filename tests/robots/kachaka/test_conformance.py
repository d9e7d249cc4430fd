"""Every component of the Kachaka, tried from outside as any application would."""

import pytest
from openrois_conformance.checks import ALL_CHECKS
from openrois_conformance.stage import Needs
from openrois_conformance.suite import Outcome, run_checks, visit

from openrois.client import Client
from tests.support.kachaka_home import home

pytestmark = pytest.mark.media

PATIENCE = 20.0
"""Seconds that an answer may take on a busy machine."""


@pytest.mark.timeout(300)
async def test_a_kachaka_conforms() -> None:
    checks = [check for check in ALL_CHECKS if Needs.COMPONENT in check.needs]
    assert checks
    async with home() as house:
        async with Client(house.url) as client:
            (body,) = await client.bodies()
        assert len(body.components) > 15
        for component in body.components:
            async with visit(house.url, PATIENCE, adapter=False, component=component.component_ref) as place:
                verdicts = await run_checks(place, checks)
            wrong = {
                each.check.id: f"{each.expected} / {each.came}" for each in verdicts if each.outcome is Outcome.FAILED
            }
            assert wrong == {}, component.component_ref
            assert {each.outcome for each in verdicts} == {Outcome.PASSED}, component.component_ref
