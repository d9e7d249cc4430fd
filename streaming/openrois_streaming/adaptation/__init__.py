"""What each viewer of a shared source is sent: estimates of its path, and the choice among renditions. Pure."""
