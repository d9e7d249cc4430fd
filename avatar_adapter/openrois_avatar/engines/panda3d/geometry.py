"""Meshes in Panda3D: vertex buffers that are rewritten from NumPy arrays."""

import numpy as np
from panda3d.core import (
    Geom,
    GeomNode,
    GeomTriangles,
    GeomVertexArrayFormat,
    GeomVertexData,
    GeomVertexFormat,
    InternalName,
    LMatrix4f,
    NodePath,
    OmniBoundingVolume,
)

from openrois_avatar.engines.figure.mesh import Faces
from openrois_avatar.engines.figure.rig import Frame
from openrois_avatar.engines.figure.shading import Bytes, Floats

_VERTICES, _COLOURS = 0, 1


def _format() -> GeomVertexFormat:
    """Positions and colours in arrays of their own, so that each can be replaced without the other."""
    positions, colours = GeomVertexArrayFormat(), GeomVertexArrayFormat()
    positions.add_column(InternalName.get_vertex(), 3, Geom.NT_float32, Geom.C_point)
    colours.add_column(InternalName.get_color(), 4, Geom.NT_uint8, Geom.C_color)
    whole = GeomVertexFormat()
    whole.add_array(positions)
    whole.add_array(colours)
    return GeomVertexFormat.register_format(whole)


class Solid:
    """A mesh of a fixed number of vertices under a node."""

    def __init__(self, name: str, parent: NodePath, faces: Faces, count: int) -> None:
        data = GeomVertexData(name, _format(), Geom.UH_dynamic)
        data.set_num_rows(count)
        triangles = GeomTriangles(Geom.UH_static)
        triangles.set_index_type(Geom.NT_uint16)
        index = triangles.modify_vertices()
        index.set_num_rows(faces.size)
        memoryview(index).cast("B")[:] = np.ascontiguousarray(faces, np.uint16).data.cast("B")
        geometry = Geom(data)
        geometry.add_primitive(triangles)
        node = GeomNode(name)
        node.add_geom(geometry)
        # Vertices move under Panda's feet: its own bounds would be those of the first frame.
        node.set_bounds(OmniBoundingVolume())
        node.set_final(True)
        # Drawn in the order of the scene, nearest first: what is hidden later is not coloured.
        self.path: NodePath = parent.attach_new_node(node)
        self.path.set_bin("unsorted", 0)
        # Asked for once: with every picture Panda3D would copy what it then writes over.
        self._data = node.modify_geom(0).modify_vertex_data()

    def move(self, vertices: Floats) -> None:
        """Replace the vertices, (n, 3)."""
        self._write(_VERTICES, vertices)

    def paint(self, colours: Bytes) -> None:
        """Replace the colours, (n, 4) RGBA."""
        self._write(_COLOURS, colours)

    def show(self, visible: bool) -> None:
        """Draw it from now on, or do not."""
        show(self.path, visible)

    def _write(self, array: int, values: Floats | Bytes) -> None:
        memoryview(self._data.modify_array(array)).cast("B")[:] = values.data.cast("B")


def show(node: NodePath, visible: bool) -> None:
    """Draw what is under a node from now on, or do not."""
    if visible == node.is_stashed():
        if visible:
            node.unstash()
        else:
            node.stash()


def matrix(frame: Frame) -> LMatrix4f:
    """A frame as Panda has it, whose matrices multiply rows from the left."""
    # As Python's own numbers: NumPy's are slow one by one.
    (a, b, c), (d, e, f), (g, h, i) = frame.rotation.tolist()
    x, y, z = frame.origin.tolist()
    return LMatrix4f(a, d, g, 0, b, e, h, 0, c, f, i, 0, x, y, z, 1)
