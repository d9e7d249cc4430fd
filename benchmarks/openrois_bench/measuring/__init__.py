"""Conditions of the machine, statistics and tables of results; it measures nothing."""
