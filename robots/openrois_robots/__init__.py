"""Robots behind RoIS, each an adapter of its own, and the command that runs them."""
