"""The avatar as clay: fields, meshes, colours and joints, made by code and moved by poses. NumPy only, no renderer."""
