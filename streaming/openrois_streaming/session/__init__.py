"""Streams of applications, and the sessions that they belong to; `peer` carries them."""
