"""The operator's camera as a sense: faces are found, followed, placed, recognised, and their gestures read."""
