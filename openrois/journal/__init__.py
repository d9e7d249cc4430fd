"""The journal of commands: what was accepted gets its one end, also when the gateway was restarted meanwhile."""
