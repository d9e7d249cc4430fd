"""Charts of what was measured: from `benchmarks/results` to `docs`, see `__main__`."""
