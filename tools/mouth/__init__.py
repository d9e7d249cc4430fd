"""Fits the weights that read a mouth from sound to sentences, changed as voices, rooms and microphones differ."""
