"""The mapping file: which topics and actions of a robot are behind which components."""
