"""The common part of all senses: when they are active, and which changes they announce. Pure."""
