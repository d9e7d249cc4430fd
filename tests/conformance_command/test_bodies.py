"""Every component of the avatar and of the robot, tried from outside as any application would."""

from collections.abc import Iterator

import pytest
from openrois_conformance.checks import ALL_CHECKS
from openrois_conformance.stage import Needs
from openrois_conformance.suite import Outcome, run_checks, visit

from openrois.client import Client
from tests.support.demo import Demo, running_demo

pytestmark = pytest.mark.engine

PATIENCE = 20.0
"""Seconds that an answer may take on a busy machine."""


@pytest.fixture(scope="module")
def demo(panda3d: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    with running_demo(tmp_path_factory.mktemp("bodies"), "panda3d", ("--with", "robot")) as demo:
        yield demo


@pytest.mark.parametrize("engine_id", ["avatar", "robot"])
async def test_a_body_conforms(demo: Demo, engine_id: str) -> None:
    checks = [check for check in ALL_CHECKS if Needs.COMPONENT in check.needs]
    assert checks
    async with Client(demo.url) as client:
        (body,) = (each for each in await client.bodies() if each.engine_id == engine_id)
    assert len(body.components) > 10
    for component in body.components:
        async with visit(demo.url, PATIENCE, adapter=False, component=component.component_ref) as place:
            verdicts = await run_checks(place, checks)
        wrong = {each.check.id: f"{each.expected} / {each.came}" for each in verdicts if each.outcome is Outcome.FAILED}
        assert wrong == {}, component.component_ref
        assert {each.outcome for each in verdicts} == {Outcome.PASSED}, component.component_ref
