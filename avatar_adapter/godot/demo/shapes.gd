# Primitives of many colours put together into one mesh: one thing to draw costs less than many.
extends Reference

const AMBIENT := Color(0.5, 0.51, 0.55)
const LAMP := Color(0.75, 0.72, 0.68)

# Where the light comes from, for what never moves: it is painted on, which costs nothing when it is drawn.
var painted_from := Vector3.ZERO

var _vertices := PoolVector3Array()
var _normals := PoolVector3Array()
var _colours := PoolColorArray()
var _indices := PoolIntArray()


func box(size: Vector3, at: Vector3, colour: Color) -> void:
	var mesh := CubeMesh.new()
	mesh.size = size
	_add(mesh, Transform(Basis(), at), colour)


# A flat square on the floor.
func tile(side: float, at: Vector3, colour: Color) -> void:
	var mesh := PlaneMesh.new()
	mesh.size = Vector2(side, side)
	_add(mesh, Transform(Basis(), at), colour)


# An upright cylinder that stands at `at`.
func tube(radius: float, height: float, at: Vector3, colour: Color) -> void:
	var mesh := CylinderMesh.new()
	mesh.top_radius = radius
	mesh.bottom_radius = radius
	mesh.height = height
	mesh.radial_segments = 18
	mesh.rings = 1
	_add(mesh, Transform(Basis(), at + Vector3(0, height / 2, 0)), colour)


# An ellipsoid with these radii.
func ball(radii: Vector3, at: Vector3, colour: Color) -> void:
	var is_large: bool = radii[radii.max_axis()] > 0.09
	var mesh := SphereMesh.new()
	mesh.radial_segments = 18 if is_large else 10
	mesh.rings = 9 if is_large else 5
	mesh.radius = 1.0
	mesh.height = 2.0
	_add(mesh, Transform(Basis().scaled(radii), at), colour)


# An upright capsule; `length` is without its ends.
func limb(radius: float, length: float, at: Vector3, colour: Color) -> void:
	var mesh := CapsuleMesh.new()
	mesh.radial_segments = 12
	mesh.rings = 4
	mesh.radius = radius
	mesh.mid_height = length
	_add(mesh, Transform(Basis(Vector3.RIGHT, PI / 2), at), colour)


# What was put together, drawn as a child of `parent`; light falls on it unless it is painted on or all is `flat`.
func draw_in(parent: Spatial, flat := false) -> void:
	if _indices.empty():
		return
	var arrays := []
	arrays.resize(Mesh.ARRAY_MAX)
	arrays[Mesh.ARRAY_VERTEX] = _vertices
	arrays[Mesh.ARRAY_NORMAL] = _normals
	arrays[Mesh.ARRAY_COLOR] = _colours
	arrays[Mesh.ARRAY_INDEX] = _indices
	var mesh := ArrayMesh.new()
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
	var material := SpatialMaterial.new()
	material.vertex_color_use_as_albedo = true
	material.flags_transparent = flat
	material.flags_unshaded = flat or painted_from != Vector3.ZERO
	material.params_diffuse_mode = SpatialMaterial.DIFFUSE_LAMBERT
	material.params_specular_mode = SpatialMaterial.SPECULAR_DISABLED
	mesh.surface_set_material(0, material)
	var instance := MeshInstance.new()
	instance.mesh = mesh
	parent.add_child(instance)


func _add(mesh: PrimitiveMesh, at: Transform, colour: Color) -> void:
	var arrays := mesh.get_mesh_arrays()
	var first := _vertices.size()
	_vertices.append_array(at.xform(arrays[Mesh.ARRAY_VERTEX]))
	# Of what is stretched the normals lean the other way.
	var leaning := at.basis.inverse().transposed()
	for normal in arrays[Mesh.ARRAY_NORMAL]:
		var turned := leaning.xform(normal).normalized()
		_normals.append(turned)
		_colours.append(colour if painted_from == Vector3.ZERO else colour * _light(turned))
	for index in arrays[Mesh.ARRAY_INDEX]:
		_indices.append(first + index)


func _light(normal: Vector3) -> Color:
	var light := AMBIENT + LAMP * max(0.0, normal.dot(painted_from))
	light.a = 1.0
	return light
