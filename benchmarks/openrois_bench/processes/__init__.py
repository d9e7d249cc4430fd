"""The processes of a measurement: starting them, asking them, and what the system says they have used."""
