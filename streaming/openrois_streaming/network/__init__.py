"""How peer connections meet the network: which addresses and ports they use, what they let in, and relays."""
