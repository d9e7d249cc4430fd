"""RoIS components that every body may have; each translates between RoIS and a room of this package."""
