"""RoIS profiles in the standard's XML and in JSON, and the command that converts them."""
