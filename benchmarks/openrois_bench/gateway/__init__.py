"""Cost of a call and an event at the gateway, in processor time and delay, beside the floor of the machine."""
