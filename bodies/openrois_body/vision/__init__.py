"""The operator's camera as a sense: faces are found, tracked, located, recognised, and their gestures read."""
