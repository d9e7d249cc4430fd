"""Components that only the simulated robot has, or has otherwise than other bodies."""
