"""The scope of a principal: what it sees of an engine and of its faults; principals are in `auth`."""
