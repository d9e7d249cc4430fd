"""Child processes that end with their parent, whatever program they run."""
