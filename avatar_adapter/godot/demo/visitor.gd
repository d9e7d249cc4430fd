# A visitor that strolls through the room, stays a while here and there, and waves when the figure is near.
extends Node

const PLACES := [[2.4, 0.9], [2.5, 3.2], [0.2, 3.2], [-0.5, 1.6], [0.3, 3.0], [2.5, 3.3]]
const SPEED := 0.6
const TURNING := 2.5
const APART := 0.6  # metres at which one waits for the other
const NEAR := 1.3

var _body: Spatial
var _other: Spatial
var _next := 1
var _stay := 4.0
var _waved := false


func _ready() -> void:
	_body = get_parent()
	_body.translation = Vector3(PLACES[0][0], 0, -PLACES[0][1])
	_body.rotation.y = -0.8


func keep_away_from(other: Spatial) -> void:
	_other = other


# The visitor as the engine link has it.
func thing() -> Dictionary:
	var at := _body.translation
	var th := stepify(wrapf(_body.rotation.y - PI / 2, -PI, PI), 0.001)
	return {"id": "visitor", "kind": "person", "name": "Visitor", "x": stepify(at.x, 0.001), "y": stepify(-at.z, 0.001), "th": th}


func _process(delta: float) -> void:
	var speed := _go(delta)
	_body.walk(speed, 0.0, 0.0, delta, 0.0)
	var near := _body.translation.distance_to(_other.translation) < NEAR
	if near and not _waved:
		_body.react("wave")
	_waved = near


# One frame of its stroll; returns how fast it goes.
func _go(delta: float) -> float:
	_stay -= delta
	if _stay > 0.0:
		return 0.0
	var way := Vector3(PLACES[_next][0], 0, -PLACES[_next][1]) - _body.translation
	var off := wrapf(atan2(way.x, way.z) - _body.rotation.y, -PI, PI)
	_body.rotation.y += clamp(off, -TURNING * delta, TURNING * delta)
	if abs(off) > 0.3 or _is_in_the_way(way):
		return 0.0
	_body.translation += way.normalized() * min(SPEED * delta, way.length())
	if way.length() < 0.05:
		_next = (_next + 1) % PLACES.size()
		_stay = 5.0
	return SPEED


func _is_in_the_way(way: Vector3) -> bool:
	var towards := _other.translation - _body.translation
	return towards.length() < APART and towards.dot(way) > 0.0
