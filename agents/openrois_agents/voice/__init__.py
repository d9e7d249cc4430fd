"""A body's voice and ears for frameworks of voice agents: what an adapter to each needs, and none is known here."""
