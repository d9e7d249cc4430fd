"""The embedded game engines: child processes that render the avatar onto the engine link.

`animation` is pure and says what the avatar's body does at a moment, `room` where it is, who else is there, and from
where it is seen; `panda3d` shows it as a sculpted figure and `puppet` as a flat drawing; `runner` is the loop that both
run in.
"""
