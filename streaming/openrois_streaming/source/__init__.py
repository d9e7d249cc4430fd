"""Raw frames, the contract of media sources, and one source for many readers; nothing is encoded here."""
