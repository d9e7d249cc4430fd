"""Cost of a further viewer to the sending process, beside aiortc; other senders are in `peers`."""
