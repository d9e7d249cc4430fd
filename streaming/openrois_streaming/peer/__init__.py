"""Peer connections, their m-sections and data channels; which streams there are, `session` says."""
