"""Reaction times to faults: until a fault is noticed, or a motion stopped, in seconds."""
