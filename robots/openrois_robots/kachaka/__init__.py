"""The adapter of a Kachaka, a robot that carries shelves."""
