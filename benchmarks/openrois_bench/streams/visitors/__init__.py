"""Cost of visitors to the avatar adapter: what they send, what listeners get of it, and what is recognised."""
