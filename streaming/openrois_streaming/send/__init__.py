"""Sends one frame, encoded once, to each of its viewers."""
