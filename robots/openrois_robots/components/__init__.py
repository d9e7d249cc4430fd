"""Components that every robot may have, and bodies without a battery have otherwise."""
