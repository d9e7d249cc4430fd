"""What is in the simulated rooms: their plan, and the person who walks about in them. Pure."""
