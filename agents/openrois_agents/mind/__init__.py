"""A mind in a body: a conversation with a visitor, led by the tools of agents."""
