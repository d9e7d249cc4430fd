"""Prometheus figures of an adapter's streams, renditions and sources."""
