"""Negotiation of WebRTC sessions: messages, the pure state machine, and the relay between two ends."""

from openrois_signaling.messages import (
    Answer,
    Bye,
    Candidate,
    CaptureClocks,
    Direction,
    IceServer,
    MediaKind,
    Offer,
    Restart,
    SenderClock,
    StreamSection,
)
from openrois_signaling.methods import Handler, IceServers, InvalidParams, TooLong, signaling_methods
from openrois_signaling.negotiation import IllegalTransition, Negotiation, State, Verdict
from openrois_signaling.relay import Refused, Relay

__all__ = [
    "Answer",
    "Bye",
    "Candidate",
    "CaptureClocks",
    "Direction",
    "Handler",
    "IceServer",
    "IceServers",
    "IllegalTransition",
    "InvalidParams",
    "MediaKind",
    "Negotiation",
    "Offer",
    "Refused",
    "Relay",
    "Restart",
    "SenderClock",
    "State",
    "StreamSection",
    "TooLong",
    "Verdict",
    "signaling_methods",
]
