"""The figure: its joints, parts and light, and how a pose moves them; its meshes are read. NumPy only, no renderer.

The `.npz` files beside these modules are written by `python -m tools.sculpt` and never by hand.
"""
