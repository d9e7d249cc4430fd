"""Lip sync over minutes: see `__main__`."""
