"""Leases: the holder of each component, the queue for it, and hand-over."""
