"""Chromium behind bad networks: see `__main__`."""
