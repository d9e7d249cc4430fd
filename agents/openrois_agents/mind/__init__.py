"""A conversation in a body: what a visitor says is heard, understood and answered."""
