"""Meshes and textures in Panda3D."""

import numpy as np
from numpy.typing import NDArray
from panda3d.core import (
    Geom,
    GeomNode,
    GeomTriangles,
    GeomVertexArrayFormat,
    GeomVertexData,
    GeomVertexFormat,
    InternalName,
    NodePath,
    SamplerState,
    Texture,
)

from openrois_robots.simulated.drawing.meshes import Mesh

__all__ = ["add_mesh", "make_texture"]


def add_mesh(name: str, parent: NodePath, mesh: Mesh) -> NodePath:
    """Add a mesh under a node, and return its own node."""
    count = len(mesh.vertices)
    rows = np.zeros(count, [("place", np.float32, 3), ("colour", np.uint8, 4), ("texture", np.float32, 2)])
    rows["place"], rows["texture"] = mesh.vertices, mesh.places
    rows["colour"][:, :3] = np.round(mesh.colours * 255)
    rows["colour"][:, 3] = 255
    data = GeomVertexData(name, _format(), Geom.UH_static)
    data.set_num_rows(count)
    memoryview(data.modify_array(0)).cast("B")[:] = rows.tobytes()
    triangles = GeomTriangles(Geom.UH_static)
    triangles.set_index_type(Geom.NT_uint16)
    index = triangles.modify_vertices()
    index.set_num_rows(mesh.faces.size)
    memoryview(index).cast("B")[:] = np.ascontiguousarray(mesh.faces).tobytes()
    geometry = Geom(data)
    geometry.add_primitive(triangles)
    node = GeomNode(name)
    node.add_geom(geometry)
    return parent.attach_new_node(node)


def make_texture(image: NDArray[np.uint8], *, repeats: bool = False) -> Texture:
    """Return a texture of an RGB image (height, width, 3), top row first; a power of two high and wide."""
    texture = Texture()
    height, width = image.shape[:2]
    texture.setup_2d_texture(width, height, Texture.T_unsigned_byte, Texture.F_rgb)
    # Panda3D has the lowest row first, and blue before red.
    texture.set_ram_image(np.ascontiguousarray(image[::-1, :, ::-1]).tobytes())
    wrap = SamplerState.WM_repeat if repeats else SamplerState.WM_clamp
    texture.set_wrap_u(wrap)
    texture.set_wrap_v(wrap)
    texture.set_minfilter(SamplerState.FT_linear_mipmap_nearest)
    texture.set_magfilter(SamplerState.FT_linear)
    return texture


def _format() -> GeomVertexFormat:
    array = GeomVertexArrayFormat()
    array.add_column(InternalName.get_vertex(), 3, Geom.NT_float32, Geom.C_point)
    array.add_column(InternalName.get_color(), 4, Geom.NT_uint8, Geom.C_color)
    array.add_column(InternalName.get_texcoord(), 2, Geom.NT_float32, Geom.C_texcoord)
    whole = GeomVertexFormat()
    whole.add_array(array)
    return GeomVertexFormat.register_format(whole)
