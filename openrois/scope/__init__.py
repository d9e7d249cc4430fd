"""What a principal sees of an engine and of its faults; who the principal is, `auth` says."""
