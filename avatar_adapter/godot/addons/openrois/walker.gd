# Sends a character about: obeys walk, drive and halt of an OpenRoISLink, moves `body`, and tells what is reached.
#
# `body` is a Spatial whose front is +Z and whose parent is not moved or turned. `ahead`, `left` and `turn` say how it
# moves now, for the animation of its legs.
extends Node

const HOLD := 0.45  # seconds for which a drive holds, a frame less than it may
const GAIN := 2.0  # m/s^2
const FASTEST := 2.5  # m/s
const TURNING := 3.0  # rad/s
const ASIDE := 0.4  # metres before a point with a direction at which the body turns that way
const FACED := 0.01  # radians
const _NEAR := 0.0005
const _STEP := 0.02  # metres after which one looks again whether there is something in the way

export(NodePath) var link := NodePath()
export(NodePath) var body := NodePath()
export(float) var radius := 0.25

var ahead := 0.0
var left := 0.0
var turn := 0.0

var _link: Node = null
var _body: Spatial = null
var _at := Vector2()  # on the floor, in the link's axes
var _th := 0.0
var _id := ""
var _path := []
var _index := 0
var _wanted := 0.0  # speed of a walk
var _speed := 0.0
var _drive := Vector3()
var _drive_until := 0
var _outline := PoolVector2Array()
var _obstacles := []
var _told := Vector3(INF, INF, INF)


func _ready() -> void:
	_link = get_node(link)
	_body = get_node(body)
	_at = _link.from_world(_body.translation)
	_th = _link.from_rotation(_body.rotation.y)
	_link.connect("walk", self, "_on_walk")
	_link.connect("drive", self, "_on_drive")
	_link.connect("halt", self, "_on_halt")
	_link.connect("disconnected", self, "_on_disconnected")


# Tells the adapter the floor (see OpenRoISLink.floor_plan), and keeps the body on it where it is driven by hand.
func set_floor(outline: Array, obstacles: Array) -> void:
	_outline = _polygon(outline)
	_obstacles = []
	for obstacle in obstacles:
		_obstacles.append(_polygon(obstacle))
	_link.floor_plan(outline, obstacles)


# Where the body is: x, y and th.
func place() -> Vector3:
	return Vector3(_at.x, _at.y, _th)


func _process(delta: float) -> void:
	var before := place()
	if not _path.empty():
		_walk(delta)
	elif _link.now_usec() < _drive_until:
		_steer(delta)
	var moved := Vector2(_at.x - before.x, _at.y - before.y).rotated(-_th) / max(delta, 0.001)
	ahead = moved.x
	left = moved.y
	turn = _difference(before.z, _th) / max(delta, 0.001)
	_body.translation = _link.to_world(_at.x, _at.y) + Vector3(0, _body.translation.y, 0)
	_body.rotation.y = _link.to_rotation(_th)
	if place() != _told:
		_told = place()
		_link.place(_at.x, _at.y, _th)


func _on_walk(id: String, path: Array, speed: float) -> void:
	_give_up()
	_id = id
	_path = path
	_index = 0
	_wanted = min(speed, FASTEST)
	_speed = 0.0


func _on_drive(new_ahead: float, new_left: float, new_turn: float) -> void:
	_give_up()
	_drive = Vector3(new_ahead, new_left, new_turn)
	_drive_until = _link.now_usec() + int(HOLD * 1e6)


func _on_halt() -> void:
	_give_up()
	_drive_until = 0


func _on_disconnected(_reason: String) -> void:
	_path = []
	_drive_until = 0


func _give_up() -> void:
	if not _path.empty():
		_path = []
		_link.completed(_id, "ABORT")


# Goes on along the path for so many seconds.
func _walk(seconds: float) -> void:
	var time := seconds
	while time > 0.0 and not _path.empty():
		var goal: Array = _path[_index]
		var way := Vector2(goal[0], goal[1]) - _at
		var distance := way.length()
		if distance > _NEAR:
			time -= _go(way, distance, goal[2], time)
		else:
			var off := 0.0 if goal[2] == null else _difference(_th, goal[2])
			if abs(off) > FACED:
				time -= _face(off, time)
				continue
			_link.reached(_id, _index)
			_index += 1
			if _index == _path.size():
				_path = []
				_link.completed(_id, "OK")


# Goes straight on, turning to where it goes; returns the seconds that took.
func _go(way: Vector2, distance: float, direction, time: float) -> float:
	var off := _difference(_th, way.angle())
	if direction != null and distance < ASIDE:
		off = _difference(_th, direction)
	elif abs(off) > 0.7:
		_speed = 0.0
		return _face(off, time)
	_speed = min(_speed + GAIN * time, _wanted)
	if _index == _path.size() - 1:
		_speed = min(_speed, max(0.1, sqrt(2.0 * GAIN * distance)))
	var taken := min(time, distance / _speed)
	_face(off, taken)
	_at += way * min(1.0, _speed * taken / distance)
	return taken


# Turns by `off` as far as `time` allows; returns the seconds that took.
func _face(off: float, time: float) -> float:
	var turned := clamp(off, -TURNING * time, TURNING * time)
	_th = wrapf(_th + turned, -PI, PI)
	return max(abs(turned) / TURNING, 0.0001)


# Goes by hand; what is in the way is not entered.
func _steer(seconds: float) -> void:
	_th = wrapf(_th + clamp(_drive.z, -TURNING, TURNING) * seconds, -PI, PI)
	var way := Vector2(_drive.x, _drive.y).clamped(FASTEST).rotated(_th) * seconds
	var steps := int(ceil(way.length() / _STEP))
	for _number in steps:
		# Along a wall it slides.
		for part in [way / steps, Vector2(way.x / steps, 0), Vector2(0, way.y / steps)]:
			if _fits(_at + part):
				_at += part
				break


func _fits(at: Vector2) -> bool:
	if _outline.empty():
		return true
	if not Geometry.is_point_in_polygon(at, _outline) or _distance(at, _outline) < radius:
		return false
	for obstacle in _obstacles:
		if Geometry.is_point_in_polygon(at, obstacle) or _distance(at, obstacle) < radius:
			return false
	return true


static func _distance(at: Vector2, polygon: PoolVector2Array) -> float:
	var nearest := INF
	for index in polygon.size():
		var close := Geometry.get_closest_point_to_segment_2d(at, polygon[index - 1], polygon[index])
		nearest = min(nearest, at.distance_to(close))
	return nearest


static func _polygon(corners: Array) -> PoolVector2Array:
	var polygon := PoolVector2Array()
	for corner in corners:
		polygon.append(Vector2(corner[0], corner[1]))
	return polygon


static func _difference(from: float, to: float) -> float:
	return wrapf(to - from, -PI, PI)
