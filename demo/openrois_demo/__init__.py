"""Programs for one machine: the demo, which starts a gateway and an avatar as processes, and the doctor."""
