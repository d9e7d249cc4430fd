"""Sources made of what there is: iterators, devices, and the output of programs. It refuses to know viewers."""
