"""Receiving what an application sends: its microphone and its camera, as sources that whoever likes can open."""
