"""Costs of game engines: drawing a picture, handing it to the adapter, and standing unwatched."""
