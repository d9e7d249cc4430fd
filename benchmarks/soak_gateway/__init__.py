"""A soak test of the control plane: applications come, work, leave and are cut off, and nothing may be left of them."""
