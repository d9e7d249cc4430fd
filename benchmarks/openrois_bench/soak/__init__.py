"""Runs of minutes and hours: clients come, work, leave and are cut off, and may leave nothing behind."""
