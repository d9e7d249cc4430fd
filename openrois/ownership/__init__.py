"""Which gateway owns which engine: claims, their epochs, and how long they hold."""
