"""The example of the guide, as a person runs it, without a network."""

from pathlib import Path

import pytest

from tests.support.voice_agents import hear_parrot

pytestmark = [pytest.mark.agents, pytest.mark.media]


async def test_the_parrot_repeats_what_a_visitor_says(tmp_path: Path) -> None:
    await hear_parrot(tmp_path, "pipecat_agent.py")
