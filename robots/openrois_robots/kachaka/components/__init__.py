"""The components of a Kachaka."""
