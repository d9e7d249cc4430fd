"""Peer connections, their m-sections and data channels; the streams belong to `session`."""
