"""From a game engine to the adapter: see `__main__`."""
