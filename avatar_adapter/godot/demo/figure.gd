# A figure of primitives, 1.75 m tall, that looks along +Z: it breathes, blinks, looks, speaks, gestures and walks.
extends Spatial

const Reactions := preload("reactions.gd")
const Shapes := preload("shapes.gd")

const CHANNELS := [
	"pitch", "yaw", "roll", "lean", "twist", "hop", "smile", "brow", "shoulders",
	"r_raise", "r_out", "r_elbow", "r_bend", "l_raise", "l_out", "l_elbow", "l_bend",
]
# What the mouth does for each viseme at full weight: open, wide (below 0: round), teeth.
const MOUTHS := {
	"sil": [0.0, 0.0, 0.0], "PP": [-0.25, -0.1, 0.0], "FF": [0.08, 0.05, 0.9], "TH": [0.2, 0.1, 0.6],
	"DD": [0.2, 0.15, 0.6], "kk": [0.3, 0.1, 0.3], "CH": [0.2, -0.5, 0.8], "SS": [0.1, 0.45, 1.0],
	"nn": [0.15, 0.1, 0.4], "RR": [0.22, -0.4, 0.3], "aa": [1.0, 0.1, 0.4], "E": [0.5, 0.55, 0.6],
	"ih": [0.3, 0.7, 0.7], "oh": [0.7, -0.55, 0.0], "ou": [0.35, -0.9, 0.0],
}
const STRIDE := 0.62  # metres of one step
const JUMP := 2.4  # m/s upward, of a jump
const _GRAVITY := 9.8
const _DUCKED := 0.25  # metres by which it is less tall then
const _SMOOTH := 16.0  # how fast the body follows what it shall do, per second

export(Color) var skin := Color(0.93, 0.74, 0.6)
export(Color) var hair := Color(0.22, 0.15, 0.12)
export(Color) var shirt := Color(0.2, 0.45, 0.65)
export(Color) var trousers := Color(0.2, 0.22, 0.3)

var _time := 0.0
var _chance := RandomNumberGenerator.new()
var _blink_at := 2.0
var _reaction := {}
var _reaction_time := 0.0
var _shown := {}  # by channel
var _gaze := Vector2()
var _gaze_shown := Vector2()
var _mouth := Vector3()
var _rising := 0.0  # m/s
var _height := 0.0  # metres above the floor
var _ducking := 0.0  # wanted, 0 or 1
var _ducked := 0.0  # shown
var _phase := 0.0  # of walking, in steps
var _sounded := 0  # steps that have been told
var _stepping := 0.0  # how much of its legs' movement is seen, 0..1

var _spine: Spatial
var _head: Spatial
var _eyes := []
var _brows: Spatial
var _lips: Spatial
var _inside: Spatial
var _teeth: Spatial
var _arms := {}
var _legs := {}


func _ready() -> void:
	_chance.seed = hash(name)
	for channel in CHANNELS:
		_shown[channel] = 0.0
	_build()


# Begin a reaction; another one is given up.
func react(reaction: String) -> void:
	_reaction = Reactions.ALL[reaction]
	_reaction_time = 0.0


# Give up the reaction.
func rest() -> void:
	_reaction = {}


# x from -1 (the viewer's left) to 1, y from -1 (down) to 1.
func look(x: float, y: float) -> void:
	_gaze = Vector2(x, y)


# Jump once; one that is in the air already does not.
func jump() -> void:
	if _height == 0.0:
		_rising = JUMP


func duck(on: bool) -> void:
	_ducking = 1.0 if on else 0.0


# What the mouth shall do: weights by the names of visemes.
func set_mouth(weights: Dictionary) -> void:
	_mouth = Vector3()
	for shape in weights:
		var mouth: Array = MOUTHS[shape]
		_mouth += Vector3(mouth[0], mouth[1], mouth[2]) * weights[shape]


# Move the legs as this velocity wants it (m/s ahead and to the left, rad/s). Returns whether a foot will be set down
# within `early` seconds, once for each step.
func walk(ahead: float, left: float, turn: float, delta: float, early: float) -> bool:
	var speed := Vector2(ahead, left).length()
	var pace := max(speed, abs(turn) * 0.25) / STRIDE * (-1.0 if ahead < -0.05 else 1.0)
	_stepping += (clamp(abs(pace) * 1.5, 0.0, 1.0) - _stepping) * (1.0 - exp(-10.0 * delta))
	_phase += pace * delta
	var steps := int(floor(_phase + pace * early))
	var stepped := steps != _sounded and abs(pace) > 0.1
	_sounded = steps
	return stepped


func _process(delta: float) -> void:
	_time += delta
	_reaction_time += delta
	if not _reaction.empty() and _reaction_time > _reaction["seconds"]:
		_reaction = {}
	var share := 1.0 - exp(-_SMOOTH * delta)
	for channel in CHANNELS:
		var wanted := Reactions.value(_reaction, channel, _reaction_time) if not _reaction.empty() else 0.0
		_shown[channel] += (wanted - _shown[channel]) * share
	_gaze_shown += (_gaze - _gaze_shown) * (1.0 - exp(-8.0 * delta))
	_ducked += (_ducking - _ducked) * share
	_height = max(0.0, _height + _rising * delta)
	_rising = _rising - _GRAVITY * delta if _height > 0.0 else 0.0
	_pose_body()
	_pose_face()


func _pose_body() -> void:
	var swing := sin(_phase * PI) * _stepping
	var breath := sin(_time * 1.6)
	var hips: float = 0.8 + _shown["hop"] + _height - _DUCKED * _ducked
	_spine.translation.y = hips + 0.025 * abs(swing) - 0.02 * _stepping
	_spine.rotation = Vector3(_shown["lean"] + 0.05 * _stepping, _shown["twist"] + 0.07 * swing, 0)
	_spine.scale = Vector3(1.0, 1.0 + 0.006 * breath, 1.0 + 0.012 * breath)
	_head.rotation = Vector3(
		_shown["pitch"] - 0.22 * _gaze_shown.y + 0.015 * sin(_time * 0.9),
		_shown["yaw"] + 0.4 * _gaze_shown.x + 0.02 * sin(_time * 0.63),
		_shown["roll"] + 0.012 * sin(_time * 0.47)
	)
	for side in _arms:
		var away := 1.0 if side == "l" else -1.0
		var shoulder: Spatial = _arms[side][0]
		var elbow: Spatial = _arms[side][1]
		var step := -0.5 * swing * away
		shoulder.translation.y = 0.42 + _shown["shoulders"]
		shoulder.rotation = Vector3(-_shown[side + "_raise"] + step, 0, away * (0.14 + _shown[side + "_out"]))
		elbow.rotation = Vector3(-0.15 - _shown[side + "_elbow"] - 0.25 * _stepping, 0, away * _shown[side + "_bend"])
	for side in _legs:
		var ahead := swing if side == "l" else -swing
		var lift := max(0.0, cos(_phase * PI) * (1.0 if side == "l" else -1.0)) * _stepping
		_legs[side][0].translation.y = hips
		_legs[side][0].rotation.x = -0.55 * ahead - 0.2 * lift - 0.85 * _ducked
		_legs[side][1].rotation.x = 0.1 * _stepping + 0.75 * lift + 1.7 * _ducked


func _pose_face() -> void:
	if _time > _blink_at + 0.16:
		_blink_at = _time + _chance.randf_range(1.5, 5.0)
	var lids := clamp(1.0 - abs(_time - _blink_at - 0.08) / 0.07, 0.0, 1.0)
	for eye in _eyes:
		eye.rotation = Vector3(-0.35 * _gaze_shown.y, 0.45 * _gaze_shown.x, 0)
		eye.scale = Vector3(1, 1.0 - 0.9 * lids, 1)
	_brows.translation.y = 0.125 + 0.03 * _shown["brow"]
	var opened := clamp(_mouth.x, -0.25, 1.0)
	var width := 1.0 + 0.35 * _mouth.y + 0.3 * _shown["smile"]
	_lips.scale = Vector3(0.078 * width, 0.022 + 0.055 * opened, 0.03)
	_inside.scale = Vector3(0.06 * width, max(0.004, 0.006 + 0.05 * opened), 0.03)
	_teeth.scale = Vector3(0.045 * width, max(0.001, 0.016 * clamp(_mouth.z, 0.0, 1.0)), 0.03)
	_teeth.translation.y = -0.105 + 0.6 * max(0.0, 0.05 * opened)


# ---- how it is made: joints that move, each with what hangs on it as one mesh ----

func _build() -> void:
	var shadow := Shapes.new()
	shadow.ball(Vector3(0.3, 0.004, 0.24), Vector3(0, 0.006, 0), Color(0, 0, 0, 0.3))
	shadow.draw_in(self, true)
	var trunk := Shapes.new()
	trunk.ball(Vector3(0.19, 0.15, 0.145), Vector3(0, 0.03, 0), trousers)
	trunk.limb(0.17, 0.22, Vector3(0, 0.27, 0), shirt)
	trunk.ball(Vector3(0.235, 0.1, 0.145), Vector3(0, 0.4, 0), shirt)
	trunk.limb(0.06, 0.08, Vector3(0, 0.52, 0), skin)
	_spine = _joint(self, Vector3(0, 0.8, 0), trunk)
	_head = _joint(_spine, Vector3(0, 0.56, 0), Shapes.new())
	_build_head()
	for side in ["r", "l"]:
		var away := 1.0 if side == "l" else -1.0
		var sleeve := Shapes.new()
		sleeve.limb(0.058, 0.22, Vector3(0, -0.12, 0), shirt)
		var shoulder := _joint(_spine, Vector3(away * 0.235, 0.42, 0), sleeve)
		var forearm := Shapes.new()
		forearm.limb(0.048, 0.2, Vector3(0, -0.1, 0), shirt)
		forearm.ball(Vector3(0.055, 0.07, 0.05), Vector3(0, -0.27, 0), skin)
		_arms[side] = [shoulder, _joint(shoulder, Vector3(0, -0.27, 0), forearm)]
		var thigh := Shapes.new()
		thigh.limb(0.08, 0.27, Vector3(0, -0.18, 0), trousers)
		var hip := _joint(self, Vector3(away * 0.1, 0.8, 0), thigh)
		var shin := Shapes.new()
		shin.limb(0.065, 0.26, Vector3(0, -0.16, 0), trousers)
		shin.ball(Vector3(0.07, 0.05, 0.125), Vector3(0, -0.37, 0.045), Color(0.15, 0.12, 0.12))
		_legs[side] = [hip, _joint(hip, Vector3(0, -0.38, 0), shin)]


func _build_head() -> void:
	var skull := Shapes.new()
	skull.ball(Vector3(0.225, 0.25, 0.225), Vector3(0, 0, 0), skin)
	skull.ball(Vector3(0.25, 0.25, 0.235), Vector3(0, 0.062, -0.058), hair)
	skull.ball(Vector3(0.16, 0.06, 0.07), Vector3(0.05, 0.215, 0.13), hair)
	skull.ball(Vector3(0.026, 0.03, 0.03), Vector3(0, -0.02, 0.225), skin.darkened(0.08))
	for away in [-1.0, 1.0]:
		skull.ball(Vector3(0.03, 0.055, 0.04), Vector3(away * 0.225, -0.01, 0.01), skin)
		skull.ball(Vector3(0.04, 0.028, 0.02), Vector3(away * 0.125, -0.07, 0.163), Color(0.92, 0.6, 0.52))
	var head := _joint(_head, Vector3(0, 0.17, 0), skull)
	var brows := Shapes.new()
	for away in [-1.0, 1.0]:
		var eye := Shapes.new()
		eye.ball(Vector3(0.047, 0.052, 0.04), Vector3(), Color(0.97, 0.97, 0.97))
		eye.ball(Vector3(0.024, 0.027, 0.018), Vector3(0, 0, 0.03), Color(0.12, 0.16, 0.25))
		_eyes.append(_joint(head, Vector3(away * 0.085, 0.045, 0.18), eye))
		brows.ball(Vector3(0.05, 0.011, 0.02), Vector3(away * 0.085, 0, 0), hair)
	_brows = _joint(head, Vector3(0, 0.125, 0.197), brows)
	_lips = _joint(head, Vector3(0, -0.12, 0.175), _unit_ball(Color(0.75, 0.38, 0.36)))
	_inside = _joint(head, Vector3(0, -0.12, 0.182), _unit_ball(Color(0.25, 0.06, 0.07)))
	_teeth = _joint(head, Vector3(0, -0.105, 0.187), _unit_ball(Color(0.96, 0.95, 0.92)))


static func _unit_ball(colour: Color) -> Shapes:
	var shapes := Shapes.new()
	shapes.ball(Vector3.ONE, Vector3(), colour)
	return shapes


static func _joint(parent: Spatial, at: Vector3, shapes: Shapes) -> Spatial:
	var joint := Spatial.new()
	joint.translation = at
	shapes.draw_in(joint)
	parent.add_child(joint)
	return joint
