"""An avatar behind a gateway, and viewers of its pictures, each a process of its own; it makes no statistics."""
