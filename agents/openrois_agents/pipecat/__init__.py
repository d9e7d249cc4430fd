"""A body as input and output transport of a pipeline of Pipecat, without a room of another service."""

from openrois.extras import needing_extra

with needing_extra("pipecat"):
    from openrois_agents.pipecat.body_transport import BodyTransport, embodied
    from openrois_agents.voice.process import run_agent

__all__ = ["BodyTransport", "embodied", "run_agent"]
