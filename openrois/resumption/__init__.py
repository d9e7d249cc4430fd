"""What outlives a gateway of a session: its line of resume tokens, and the components that it holds."""
