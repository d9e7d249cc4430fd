# The room: 6 m wide, from 1 m in front of where the figure begins to 4 m behind it, with furniture made of primitives.
extends Spatial

const Shapes := preload("shapes.gd")

const OUTLINE := [[-3.0, -1.0], [3.0, -1.0], [3.0, 4.0], [-3.0, 4.0]]
const MUSIC_BOX := {"id": "music_box", "kind": "sound", "name": "music box", "x": 1.5, "y": 1.9, "th": -1.5708}
# name: x, y, width, depth, height, and whether it is round (then `width` is its diameter).
const FURNITURE := {
	"table": [1.5, 1.9, 1.3, 0.7, 0.74, false],
	"pillar": [-1.5, 2.6, 0.4, 0.4, 2.6, true],
	"stool": [-1.7, 0.6, 0.46, 0.46, 0.46, true],
	"plant": [-2.5, 3.4, 0.56, 0.56, 0.5, true],
}
const _CORNERS := 8

var _shapes := Shapes.new()


func _ready() -> void:
	_light()
	# What is nearest comes first: what is behind it then need not be drawn.
	for name in FURNITURE:
		_furnish(name, FURNITURE[name])
	_build_floor_and_walls()
	_shapes.draw_in(self)


# The outlines of the furniture, counter-clockwise, as the engine link has them.
func obstacles() -> Array:
	var all := []
	for name in FURNITURE:
		var piece: Array = FURNITURE[name]
		var corners := []
		if piece[5]:
			for index in _CORNERS:
				var corner := Vector2(piece[2] / 2 / cos(PI / _CORNERS), 0).rotated((index + 0.5) * TAU / _CORNERS)
				corners.append([stepify(piece[0] + corner.x, 0.001), stepify(piece[1] + corner.y, 0.001)])
		else:
			for corner in [[-1, -1], [1, -1], [1, 1], [-1, 1]]:
				corners.append([piece[0] + corner[0] * piece[2] / 2, piece[1] + corner[1] * piece[3] / 2])
		all.append(corners)
	return all


# The furniture as the engine link has it.
func things() -> Array:
	var all := []
	for name in FURNITURE:
		all.append({"id": name, "kind": "object", "name": name, "x": FURNITURE[name][0], "y": FURNITURE[name][1], "th": 0})
	return all


func _light() -> void:
	var environment := Environment.new()
	environment.background_mode = Environment.BG_COLOR
	environment.background_color = Color(0.55, 0.62, 0.68)
	environment.ambient_light_color = Shapes.AMBIENT
	var world := WorldEnvironment.new()
	world.environment = environment
	add_child(world)
	var lamp := DirectionalLight.new()
	lamp.rotation = Vector3(-0.8, 0.5, 0)
	lamp.light_color = Shapes.LAMP
	add_child(lamp)
	_shapes.painted_from = lamp.transform.basis.z


func _build_floor_and_walls() -> void:
	_shapes.box(Vector3(6.4, 3.2, 0.1), Vector3(0, 1.6, -4.1), Color(0.80, 0.78, 0.72))
	_shapes.box(Vector3(6.4, 0.12, 0.12), Vector3(0, 0.06, -4.05), Color(0.95, 0.94, 0.9))
	for side in [-1, 1]:
		_shapes.box(Vector3(0.1, 3.2, 8), Vector3(side * 3.1, 1.6, -0.2), Color(0.72, 0.74, 0.74))
	# A picture on the wall, so that one sees which way one looks.
	_shapes.box(Vector3(1.3, 0.9, 0.06), Vector3(-0.2, 1.75, -4.03), Color(0.35, 0.27, 0.2))
	_shapes.box(Vector3(1.15, 0.42, 0.02), Vector3(-0.2, 1.92, -3.99), Color(0.55, 0.75, 0.9))
	_shapes.box(Vector3(1.15, 0.34, 0.02), Vector3(-0.2, 1.54, -3.99), Color(0.35, 0.6, 0.4))
	for index in 144:
		var at := Vector3(index % 12 - 5.5, 0, index / 12 - 4.5)
		var is_light := (index % 12 + index / 12) % 2 == 0
		_shapes.tile(1.0, at, Color(0.72, 0.62, 0.5) if is_light else Color(0.65, 0.55, 0.44))


func _furnish(name: String, piece: Array) -> void:
	var at := Vector3(piece[0], 0, -piece[1])
	var height: float = piece[4]
	match name:
		"table":
			_shapes.box(Vector3(piece[2], 0.06, piece[3]), at + Vector3(0, height, 0), Color(0.5, 0.34, 0.22))
			for corner in [[-1, -1], [1, -1], [1, 1], [-1, 1]]:
				var leg := Vector3(corner[0] * (piece[2] / 2 - 0.05), height / 2, corner[1] * (piece[3] / 2 - 0.05))
				_shapes.box(Vector3(0.07, height, 0.07), at + leg, Color(0.42, 0.28, 0.18))
			_shapes.box(Vector3(0.3, 0.16, 0.2), Vector3(MUSIC_BOX["x"], height + 0.11, -MUSIC_BOX["y"]), Color(0.7, 0.2, 0.25))
		"plant":
			_shapes.tube(piece[2] / 2, height, at, Color(0.72, 0.45, 0.33))
			for index in 7:
				var leaf := Vector3(0.17, 0, 0).rotated(Vector3.UP, index * 2.4) + Vector3(0, height + 0.12 + 0.07 * index, 0)
				_shapes.ball(Vector3.ONE * 0.2, at + leaf, Color(0.25, 0.5 + 0.03 * index, 0.28))
		_:
			_shapes.tube(piece[2] / 2, height, at, Color(0.85, 0.83, 0.78) if name == "pillar" else Color(0.3, 0.42, 0.5))
