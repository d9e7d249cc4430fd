"""Cost of a further viewer to other senders and this one, in one run: see `__main__`."""
