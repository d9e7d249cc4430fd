"""The daemon of a Reachy Mini, by its REST and its WebSocket."""
