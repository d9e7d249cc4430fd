"""Figures for Prometheus: what they are, how they are written, and where they are served."""
