"""Operation by hand: which application operates, how keys, sticks and pointers act, and the dead man's switch."""
