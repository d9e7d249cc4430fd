"""Ordered text messages between two ends: the contract, a pair in memory, and WebSocket."""
