# What the operator holds and presses: follows the `input` of an OpenRoISLink that `takes_input`.
#
# Keys are called as in KeyboardEvent.code ("KeyW", "Space"), the gamepad's buttons, in the W3C's standard mapping,
# "Pad0" to "Pad16", the pointer's "Mouse0" to "Mouse4". When the operator is gone or may not operate any more
# everything is released, also without a message: nothing stays pressed.
extends Node

# Something has gone down, or up again.
signal pressed(code)
signal released(code)

# The bits of MouseEvent.buttons, by button.
const _BITS := {0: 1, 1: 4, 2: 2, 3: 8, 4: 16}

export(NodePath) var link := NodePath()

# Where the pointer was last: from 0, 0 (top left of the picture) to 1, 1.
var pointer := Vector2(0.5, 0.5)

var _down := {}
var _axes := []


func _ready() -> void:
	var node := get_node(link)
	node.connect("input", self, "_on_input")
	node.connect("disconnected", self, "_on_disconnected")


func is_down(code: String) -> bool:
	return _down.has(code)


# A stick of the gamepad: 0 and 1 are the left one's x and y, 2 and 3 the right one's; up and left are -1.
func axis(number: int) -> float:
	return _axes[number] if number < _axes.size() else 0.0


func _on_input(message: Dictionary) -> void:
	if message.has("pointer"):
		pointer = Vector2(message["pointer"][0], message["pointer"][1])
	match message.get("event"):
		null, "release":  # all that is held now, which is nothing after a release
			_hold(message)
		"key":
			_set(message["code"], message["down"])
		"pad":
			_set("Pad%d" % message["button"], message["down"])
		"button":
			_set("Mouse%d" % message["button"], message["down"])
			pointer = Vector2(message["x"], message["y"])


func _on_disconnected(_reason: String) -> void:
	_hold({})


func _hold(state: Dictionary) -> void:
	var held := {}
	for code in state.get("keys", []):
		held[code] = true
	var pad: Dictionary = state.get("gamepad", {})
	_axes = pad.get("axes", [])
	var buttons: Array = pad.get("buttons", [])
	for index in buttons.size():
		if buttons[index] > 0.5:
			held["Pad%d" % index] = true
	var bits := int(state["pointer"][2]) if state.has("pointer") else 0
	for button in _BITS:
		if bits & _BITS[button]:
			held["Mouse%d" % button] = true
	for code in _down.keys():
		if not held.has(code):
			_set(code, false)
	for code in held:
		_set(code, true)


func _set(code: String, down: bool) -> void:
	if down and not _down.has(code):
		_down[code] = true
		emit_signal("pressed", code)
	elif not down and _down.erase(code):
		emit_signal("released", code)
