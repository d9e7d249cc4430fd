"""Hearing: what the operator's microphone tells: that there is sound, from where, that somebody speaks, and what."""
