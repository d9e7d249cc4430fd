"""The avatar as clay: fields, meshes and colours, made by code and baked into files that its engines read.

`python -m tools.sculpt` writes the files; nothing of this is shipped. NumPy only, no renderer.
"""
