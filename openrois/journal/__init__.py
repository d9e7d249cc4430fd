"""The journal of commands: an accepted command gets its one end, also when the gateway was restarted meanwhile."""
