"""The room that the embedded engines' figure is in: its floor, who else is there, and how one goes about in it.

Pure: times are seconds on one clock, places are metres and radians as on the engine link.
"""
