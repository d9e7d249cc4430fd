"""What a further viewer costs other senders and this one, in one run: see `__main__`."""
