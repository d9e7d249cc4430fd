"""Raw frames, the contract of what makes them, and how one source serves many readers; nothing is encoded here."""
