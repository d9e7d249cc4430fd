"""Leases: who holds which component, who waits for it, and how it changes hands."""
