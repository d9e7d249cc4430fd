"""Measurements of the media plane: delays, losses and costs of pictures and sound on their way to viewers and back."""
