"""Sound of a body: engine sound and voice, mixed without clicks; it makes no speech."""
