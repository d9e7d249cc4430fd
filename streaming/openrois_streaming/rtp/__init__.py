"""Outgoing RTP: payload formats, headers, retransmission and reports. All modules are pure."""
