"""Motion of the figure: ways round obstacles, targets as applications write them, lines and curves."""
