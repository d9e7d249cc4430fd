"""The adapter of a Reachy Mini, a head with two antennas on a body that turns."""
