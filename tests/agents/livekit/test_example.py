"""The example of the guide, as a person runs it, without a network."""

from pathlib import Path

import pytest

from tests.support.voice_agents import hear_parrot

pytestmark = [pytest.mark.agents, pytest.mark.media]


@pytest.mark.parametrize("gateway_leaves", [False, True])
async def test_the_parrot_repeats_what_a_visitor_says_and_ends(tmp_path: Path, gateway_leaves: bool) -> None:
    await hear_parrot(tmp_path, "livekit_agent.py", gateway_leaves=gateway_leaves)
