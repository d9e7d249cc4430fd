"""The embedded game engines: child processes that render the avatar onto the engine link.

`animation` is pure and computes the avatar's pose at a moment, `room` its place, the visitor, and the camera; `panda3d`
draws it as a sculpted figure and `puppet` as a flat drawing; `runner` is the loop of both.
"""
