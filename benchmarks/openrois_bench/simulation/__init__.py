"""Many gateways, bodies and applications in virtual time: what they cost, and where they saturate."""
