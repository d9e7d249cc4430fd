"""Streams of applications, and the sessions that they belong to; what carries them is in `peer`."""
