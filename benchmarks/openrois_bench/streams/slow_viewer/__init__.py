"""One viewer behind a slow path beside fast ones of the same source."""
