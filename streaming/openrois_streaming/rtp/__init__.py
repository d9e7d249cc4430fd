"""RTP as it leaves here: payload formats, headers, retransmission and reports. All of it is pure."""
