"""What agents wait for."""
