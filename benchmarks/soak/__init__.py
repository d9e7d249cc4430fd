"""A soak test: viewers join and leave for as long as wanted, and nothing may be left of them."""
