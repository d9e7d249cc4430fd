"""A robot as its topics show it: signs of life, poses, battery, velocity, pictures."""
