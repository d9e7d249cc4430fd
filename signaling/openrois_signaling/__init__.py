"""Negotiation of WebRTC sessions: messages, the pure state machine, and the relay between two ends."""
