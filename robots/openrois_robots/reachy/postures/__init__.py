"""Postures of a Reachy Mini, the ways between them, and its gestures; no robot and no clock is known here."""
