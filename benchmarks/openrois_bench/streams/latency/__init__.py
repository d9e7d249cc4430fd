"""Latency beside plain aiortc: see `__main__`."""
