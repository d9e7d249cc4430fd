"""Streams of an application, over `openrois.client`: connected, negotiated, played, sent and recovered."""
