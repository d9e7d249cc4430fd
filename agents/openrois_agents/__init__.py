"""Agents and language models with bodies: verbs that they call, and the protocols by which they do."""
