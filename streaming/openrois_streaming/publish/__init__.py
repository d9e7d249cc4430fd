"""Encodes a source once for each rendition and shares it; what is sent to a viewer, `peer` and `send` decide."""
