"""Figures for Prometheus: what each stream, rendition and source does, told to whoever scrapes the adapter."""
