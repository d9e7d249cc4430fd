"""The avatar adapter: a game engine, its voice and its streams behind RoIS components."""
