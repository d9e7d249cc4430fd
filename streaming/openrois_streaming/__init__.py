"""The media plane: sources, encoders, fan-out and peer connections."""
