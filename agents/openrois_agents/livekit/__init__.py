"""A body as ears and mouth of an `AgentSession` of LiveKit Agents, without a room of LiveKit."""

from openrois.extras import needing_extra

with needing_extra("livekit"):
    from openrois_agents.livekit.embodiment import embodied

__all__ = ["embodied"]
