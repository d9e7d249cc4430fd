"""Application's end of a peer connection: it answers offers, plays what comes, and sends what is asked for."""
