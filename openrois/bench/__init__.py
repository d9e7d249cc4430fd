"""What a call and an event cost at the gateway, in processor time and in waiting, beside the floor of the machine."""
