"""`openrois avatar check`: whether a game engine does what the engine link asks of it."""
