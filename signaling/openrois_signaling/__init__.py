"""Negotiation of WebRTC sessions: messages, the pure state machine, and the relay between two ends."""

from openrois_signaling.messages import (
    Answer,
    Bye,
    Candidate,
    Direction,
    IceServer,
    MediaKind,
    Offer,
    Restart,
    StreamSection,
)
from openrois_signaling.methods import Handler, IceServers, InvalidParams, signaling_methods
from openrois_signaling.negotiation import IllegalTransition, Negotiation, State, Verdict
from openrois_signaling.relay import Relay

__all__ = [
    "Answer",
    "Bye",
    "Candidate",
    "Direction",
    "Handler",
    "IceServer",
    "IceServers",
    "IllegalTransition",
    "InvalidParams",
    "MediaKind",
    "Negotiation",
    "Offer",
    "Relay",
    "Restart",
    "State",
    "StreamSection",
    "Verdict",
    "signaling_methods",
]
