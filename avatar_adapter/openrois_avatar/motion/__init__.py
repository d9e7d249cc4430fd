"""Where the avatar goes: ways round obstacles, targets as applications write them, and lines and curves. Pure."""
