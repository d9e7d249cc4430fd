"""Settings and command-line options of an avatar; nothing is started here."""
