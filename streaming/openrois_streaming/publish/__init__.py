"""Encodes a source once for each rendition and shares it; `peer` and `send` decide what a viewer is sent."""
