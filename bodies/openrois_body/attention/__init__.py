"""Which visitor a body attends to: by faces, by voices, or as it is told."""
