"""The avatar's RoIS components. Each profile lists exactly what the component does."""
