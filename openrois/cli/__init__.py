"""The `openrois` command and what all commands have in common; it imports no command."""
