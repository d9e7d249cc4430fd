"""A simulated daemon of a Reachy Mini, for tests and for trying an application without a robot."""
