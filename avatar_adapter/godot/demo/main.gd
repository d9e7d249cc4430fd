# The demo: a figure in a room, with everything that the engine link can ask of it.
extends Node

const Reactions := preload("reactions.gd")
const Tones := preload("tones.gd")
const Sound := preload("res://addons/openrois/sound.gd")

const _TUNE := [0, 1, 2, 1, 2, 2, 0]  # of the music box
const _BEAT_USEC := 350000
const _TUNE_EVERY_USEC := 30000000

onready var _link: Node = $Link
onready var _figure: Spatial = $Stage/Figure
onready var _stroll: Node = $Stage/Visitor/Stroll
onready var _camera: Camera = $Stage/Camera
onready var _notes := [Tones.note(523.25), Tones.note(659.25), Tones.note(783.99)]
onready var _step: PoolByteArray = Tones.step()

var _coming := []  # reactions whose sound has not been heard yet: [moment, id, name]
var _playing := ""  # the id of the reaction that is seen
var _ends := 0
var _tune_at := 0
var _tune_ends := 0


func _ready() -> void:
	$Window.texture = $Stage.get_texture()
	_link.reactions = PoolStringArray(Reactions.ALL.keys())
	for name in ["connected", "disconnected", "react", "stop", "look"]:
		_link.connect(name, self, "_on_" + name)
	$Hands.connect("pressed", self, "_on_pressed")
	$Walker.set_floor($Stage/Room.OUTLINE, $Stage/Room.obstacles())
	_stroll.keep_away_from(_figure)
	_follow(1.0)


func _process(delta: float) -> void:
	var now: int = _link.now_usec()
	while not _coming.empty() and _coming[0][0] <= now:
		_begin(_coming.pop_front())
	if _playing != "" and now >= _ends:
		_link.completed(_playing, "OK")
		_playing = ""
	_figure.set_mouth($Mouth.weights())
	_figure.duck($Hands.is_down("KeyC") or $Hands.is_down("Pad1"))
	# A step is heard when it is seen: its sound is on its way a little before.
	if _figure.walk($Walker.ahead, $Walker.left, $Walker.turn, delta, Sound.AHEAD_USEC / 1e6):
		_link.play(_step, now + Sound.AHEAD_USEC)
	_play_music(now)
	_link.things(_things(now))
	_follow(1.0 - exp(-2.5 * delta))


func _on_connected() -> void:
	_tune_at = _link.now_usec() + _TUNE_EVERY_USEC
	_tune_ends = 0


func _on_disconnected(_reason: String) -> void:
	_coming = []
	_playing = ""
	_figure.rest()


func _on_react(id: String, reaction: String) -> void:
	if not Reactions.ALL.has(reaction):
		_link.completed(id, "ERROR")
		return
	var at: int = _link.play(_notes[0])
	_link.play(_notes[2], at + 120000)
	_coming.append([at, id, reaction])


func _begin(item: Array) -> void:
	if _playing != "":
		_link.completed(_playing, "ABORT")
	_playing = item[1]
	_ends = item[0] + int(Reactions.ALL[item[2]]["seconds"] * 1e6)
	_figure.react(item[2])


func _on_stop(id: String) -> void:
	for index in range(_coming.size() - 1, -1, -1):
		if id in ["", _coming[index][1]]:
			_link.completed(_coming[index][1], "ABORT")
			_coming.remove(index)
	if _playing != "" and id in ["", _playing]:
		_link.completed(_playing, "ABORT")
		_playing = ""
		_figure.rest()
		_link.hush()


func _on_look(x: float, y: float) -> void:
	_figure.look(x, y)


# The adapter walks the figure with the operator's keys and sticks; what it knows nothing of is done here.
func _on_pressed(code: String) -> void:
	if code in ["Space", "Pad0"]:
		_figure.jump()


# The music box plays a short tune now and then; it is a source of sound as long as it does.
func _play_music(now: int) -> void:
	if not _link.is_connected_to_adapter() or now < _tune_at:
		return
	for beat in _TUNE.size():
		_tune_ends = _link.play(_notes[_TUNE[beat]], _tune_at + beat * _BEAT_USEC) + _BEAT_USEC
	_tune_at += _TUNE_EVERY_USEC


func _things(now: int) -> Array:
	var things: Array = [_stroll.thing()] + $Stage/Room.things()
	if now < _tune_ends:
		things.append($Stage/Room.MUSIC_BOX)
	return things


func _follow(share: float) -> void:
	var at := _figure.translation + Vector3(0, 1.35, 2.8)
	_camera.translation = _camera.translation.linear_interpolate(at, share)
	_camera.rotation = Vector3(-0.13, 0, 0)
