"""Gateways that serve one cluster's applications together: each for its own, at the gateways that own the engines."""
