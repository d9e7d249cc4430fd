"""Operating the avatar by hand: who may, what it does with keys, sticks and pointers, and when it stops by itself."""
