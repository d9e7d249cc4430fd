"""A body as ears and mouth of an `AgentSession` of LiveKit Agents, without a room of LiveKit."""

from openrois.extras import needing_extra

with needing_extra("livekit"):
    from openrois_agents.livekit.embodiment import embodied
    from openrois_agents.voice.process import run_agent

__all__ = ["embodied", "run_agent"]
