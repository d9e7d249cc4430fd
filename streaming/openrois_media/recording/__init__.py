"""Commands that write received media into files."""
