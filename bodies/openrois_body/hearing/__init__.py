"""Hearing at the operator's microphone: presence and bearing of a sound, speech detection and speech recognition."""
