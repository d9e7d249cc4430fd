"""`openrois avatar check`: checks a game engine against the specification of the engine link."""
