"""A mobile robot in a simulated apartment: its base, battery and camera, and the adapter that serves it."""
