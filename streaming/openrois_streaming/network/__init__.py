"""Network side of peer connections: addresses and ports, admission of datagrams, and relays."""
