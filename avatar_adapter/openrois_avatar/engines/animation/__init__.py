"""The avatar's motion: time goes in, poses come out. Nothing here reads a clock, draws, or waits."""
