"""A gateway before a fleet: what the next body costs, and what applications learn of it."""
