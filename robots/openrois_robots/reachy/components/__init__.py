"""The components of a Reachy Mini."""
