# The engine link: gives the pictures and sound of this game to an avatar adapter, and tells what the avatar shall do.
#
# Add it to the scene, connect its signals to your character, and tell it what becomes of them. It connects by itself,
# again whenever the adapter went away, and nothing here makes the game wait. Moments are microseconds of now_usec().
# Places are metres and radians as in docs/reference/engine-link.md: x right, y away from the viewer; to_world() has them in Godot's.
extends Node

const Wire := preload("wire.gd")
const Carrier := preload("carrier.gd")
const Clock := preload("clock.gd")
const Sound := preload("sound.gd")
const Picture := preload("picture.gd")

# The adapter is there, or gone (then nothing that was asked for needs an answer any more).
signal connected()
signal disconnected(reason)
# Play a reaction; answer with completed(id, ...) when it is over.
signal react(id, reaction)
# Stop the reaction `id`, or every one if it is "".
signal stop(id)
# Move the mouth: visemes are [offset_ms, shape, weight], each holds until the next. OpenRoISMouth does it.
signal speak(id, start_usec, visemes, duration_usec)
# Close the mouth now.
signal silence()
# Look at x from -1 (the viewer's left) to 1, y from -1 (down) to 1.
signal look(x, y)
# Go to each [x, y, th or null] in turn. OpenRoISWalker does these three.
signal walk(id, path, speed)
# Go with this velocity (m/s ahead, m/s to the left, rad/s to the left) until the next one, half a second at most.
signal drive(ahead, left, turn)
# Stand still now.
signal halt()
# The operator's voice, if `hears`: 48 kHz, mono, signed 16 bit.
signal heard(samples)
# What the operator does, if `takes_input`: a message of docs/reference/wire.md, "Input". OpenRoISHands keeps what is held.
signal input(message)
# The adapter wants the game to end; if `quits`, it does.
signal quit()

# tcp:host:port and the secret; empty for what an adapter that started this game has put into the environment.
export(String) var address := ""
export(String) var secret := ""
export(String) var engine_name := "godot"
# The viewport that is shown; empty for the one that this node is in.
export(NodePath) var source := NodePath()
# A multiple of 8 and one of 4.
export(int) var width := 640
export(int) var height := 360
export(float) var pictures_per_second := 30.0
export(PoolStringArray) var reactions := PoolStringArray()
# Whether play() is used, whether `heard` is wanted, whether the character can be sent about, and `input` is wanted.
export(bool) var has_sound := false
export(bool) var hears := false
export(bool) var walks := false
export(bool) var takes_input := false
export(bool) var quits := true
# Whether the game draws nothing at all while no pictures are wanted; not for a game that has a player at its window.
export(bool) var sleeps := false

const _FIRST_DELAY := 500
const _LONGEST_DELAY := 10000
# Msec between two of the same kind.
const _PACE := {"place": 50, "things": 100}
# Msec between two signs of life while no pictures are wanted.
const _SIGN := 500

var _carrier: Carrier = null
var _connected := false
var _clock := Clock.new()
var _sound := Sound.new()
var _picture: Picture = null
var _is_window := false  # the window is drawn last of all: what is read back is the frame before
var _frame_at := 0  # the moments of this frame, and of the one before
var _frame_before := 0
var _asked := 0  # the moment of the picture that is being made, 0 if none is
var _due := 0.0
var _pictures := 0
var _blocks := 0
var _delay := _FIRST_DELAY
var _again_at := 0
var _paused := false
var _wanted := true  # whether the adapter wants pictures
var _signed_at := 0
var _told := {}  # what the adapter is told again after a reconnect, by kind
var _late := {}  # kinds that are to be told as soon as their pace allows it
var _told_at := {}
var _said := {}  # the bytes that were sent last


func _init() -> void:
	pause_mode = PAUSE_MODE_PROCESS
	process_priority = -100  # commands are there before the game moves


func _ready() -> void:
	if address == "" and OS.has_environment("OPENROIS_LINK_ADDRESS"):
		address = OS.get_environment("OPENROIS_LINK_ADDRESS")
		secret = OS.get_environment("OPENROIS_LINK_SECRET")
	if width % 8 != 0 or height % 4 != 0 or not address.begins_with("tcp:"):
		push_error("OpenRoISLink: width must be a multiple of 8, height of 4, and address be tcp:host:port")
		set_process(false)
		return
	_picture = Picture.new(width, height)
	add_child(_picture)
	var viewport: Viewport = get_viewport() if source.is_empty() else get_node(source)
	_is_window = viewport == get_tree().root
	_picture.watch(viewport)
	VisualServer.connect("frame_post_draw", self, "_on_frame_drawn")


func _exit_tree() -> void:
	_want(true)
	close("the engine ends")


# ---- what the game tells ----

# Whether an adapter is there.
func is_connected_to_adapter() -> bool:
	return _connected


# Now, as the adapter counts.
func now_usec() -> int:
	return _clock.now()


# What was asked for with `id` is over: "OK" done to its end, "ABORT" stopped, "ERROR" not possible.
func completed(id: String, status: String) -> void:
	_send_event({"event": "completed", "id": id, "status": status})


# The point `index` of a walk is reached.
func reached(id: String, index: int) -> void:
	_send_event({"event": "reached", "id": id, "index": index})


# Where the character is.
func place(x: float, y: float, th: float) -> void:
	_tell("place", {"x": stepify(x, 0.0001), "y": stepify(y, 0.0001), "th": stepify(wrapf(th, -PI, PI), 0.0001)})


# Where it can go: inside of the outline (an array of [x, y]), and outside of the obstacles (an array of such arrays).
func floor_plan(outline: Array, obstacles: Array) -> void:
	_tell("floor", {"outline": outline, "obstacles": obstacles})


# All there is beside it: dictionaries with id, kind ("person", "object" or "sound"), name, x, y, th.
func things(all: Array) -> void:
	_tell("things", {"things": all})


# A line for the adapter's log.
func say(text: String) -> void:
	_send_event({"event": "log", "text": text.substr(0, 4000)})


# The game pauses: who looks at it keeps the last picture and is told so.
func pause(on: bool) -> void:
	_paused = on
	_tell("pause", {"on": on})


# Play samples (signed 16 bit, mono, 48 kHz) from the moment `at` on, or as soon as possible. Returns the moment at
# which they are heard: what is to be seen with them begins then.
func play(samples: PoolByteArray, at := 0) -> int:
	return _sound.play(samples, at)


# End every sound.
func hush() -> void:
	_sound.hush()


# Say goodbye to the adapter, for good; half a second at most.
func close(reason: String) -> void:
	set_process(false)
	if _carrier != null:
		_carrier.close(reason)
		_carrier = null
		_connected = false


# A place of the link in Godot's world, on the floor, and back.
static func to_world(x: float, y: float) -> Vector3:
	return Vector3(x, 0, -y)


static func from_world(at: Vector3) -> Vector2:
	return Vector2(at.x, -at.z)


# The rotation about y of a character whose front is +Z (as in glTF), and back.
static func to_rotation(th: float) -> float:
	return th + PI / 2


static func from_rotation(rotation_y: float) -> float:
	return rotation_y - PI / 2


# ---- once per frame ----

func _process(_delta: float) -> void:
	_clock.follow()
	if _carrier == null:
		if OS.get_ticks_msec() >= _again_at:
			_open()
		return
	if not _connected and _carrier.is_open():
		_begin()
	if _connected:
		for message in _carrier.receive():
			if _carrier != null:  # a signal's receiver may close the link
				_take(message[0], message[1])
	# The game moves after this, for this moment: not for one before the picture was wanted.
	_frame_before = _frame_at
	_frame_at = _clock.now()
	if _carrier != null and _carrier.reason() != "":
		_lose(_carrier.reason())
	elif _connected:
		_tell_what_is_late()
		_send_sound()
		_ask_for_picture()


func _open() -> void:
	var cut := address.find_last(":")
	var hello := {
		"name": engine_name,
		"version": Engine.get_version_info()["string"],
		"secret": secret,
		"video": {"width": width, "height": height, "fps": pictures_per_second, "format": "i420"},
		"audio": {"channels": 1} if has_sound else null,
		"reactions": Array(reactions),
		"hears": hears,
		"walks": walks,
		"input": takes_input,
		"demand": true,
	}
	_carrier = Carrier.new(address.substr(4, cut - 4), int(address.substr(cut + 1)), Wire.json(Wire.HELLO, hello))
	_carrier.start()


func _begin() -> void:
	if _carrier.welcome.has("now_ns"):
		_clock.set_by(_carrier.welcome["now_ns"], _carrier.welcomed_at)
	_connected = true
	_pictures = 0
	_blocks = 0
	_due = _clock.now()
	_sound.begin(_clock.now())
	_delay = _FIRST_DELAY
	_said = {}
	for kind in _told:
		_late[kind] = true
	emit_signal("connected")


func _lose(reason: String) -> void:
	_want(true)
	_carrier.close()
	_carrier = null
	_again_at = OS.get_ticks_msec() + _delay
	_delay = int(min(2 * _delay, _LONGEST_DELAY))
	if _connected:
		_connected = false
		emit_signal("disconnected", reason)
	else:
		print("OpenRoISLink: %s: %s" % [address, reason])


func _take(type: int, payload: PoolByteArray) -> void:
	if type == Wire.AUDIO:
		if payload.size() > Wire.SOUND_HEAD:
			emit_signal("heard", payload.subarray(Wire.SOUND_HEAD, payload.size() - 1))
		return
	var body = parse_json(payload.get_string_from_utf8())
	if not body is Dictionary:
		_carrier.fail("the adapter sent what is no JSON object")
	elif type == Wire.BYE:
		_carrier.fail(str(body.get("reason", "")))
	else:
		_obey(body)


func _obey(body: Dictionary) -> void:
	match body.get("command"):
		"react":
			emit_signal("react", body["id"], body["reaction"])
		"stop":
			emit_signal("stop", "" if body.get("id") == null else body["id"])
		"speak":
			var start := int(body["start_ns"] / 1000)
			emit_signal("speak", body["id"], start, body["visemes"], int(body["duration_ms"] * 1000))
		"silence":
			emit_signal("silence")
		"look":
			emit_signal("look", body["x"], body["y"])
		"walk":
			emit_signal("walk", body["id"], body["path"], body["speed"])
		"drive":
			emit_signal("drive", body["ahead"], body["left"], body["turn"])
		"halt":
			emit_signal("halt")
		"input":
			emit_signal("input", body["message"])
		"demand":
			_want(body["consumers"] > 0)
		"quit":
			emit_signal("quit")
			if quits:
				close("the engine ends")
				get_tree().quit()
		var other:
			_carrier.fail("the adapter sent an unknown command: %s" % [other])


# Make pictures from now on, or none: the next one that is wanted is drawn at once.
func _want(on: bool) -> void:
	if on == _wanted:
		return
	_wanted = on
	_due = _clock.now()
	if sleeps:
		VisualServer.render_loop_enabled = on


# Tell something of which only the newest matters, if it is new, and not oftener than its pace.
func _tell(kind: String, body: Dictionary) -> void:
	body["event"] = kind
	_told[kind] = body
	_late[kind] = true
	_tell_what_is_late()


func _tell_what_is_late() -> void:
	if not _connected:
		return
	var now := OS.get_ticks_msec()
	for kind in _late.keys():
		if now - _told_at.get(kind, -1000) >= _PACE.get(kind, 0):
			_told_at[kind] = now
			_late.erase(kind)
			var bytes := Wire.json(Wire.EVENT, _told[kind])
			if bytes != _said.get(kind):
				_said[kind] = bytes
				_carrier.put_event(bytes)


func _send_event(body: Dictionary) -> void:
	if _connected:
		_carrier.put_event(Wire.json(Wire.EVENT, body))


func _send_sound() -> void:
	if not has_sound:
		return
	for block in _sound.due(_clock.now()):
		_carrier.put_sound(Wire.audio(_blocks, _stamp(block[0]), block[1]))
		_blocks += 1


func _ask_for_picture() -> void:
	if not _wanted:
		if OS.get_ticks_msec() - _signed_at >= _SIGN:
			_signed_at = OS.get_ticks_msec()
			_send_event({"event": "idle"})
		return
	var now := _frame_at
	var period := 1e6 / pictures_per_second
	# A frame that comes a little early is better than none until the next one.
	if _paused or now < _due - period / 4:
		return
	_due = max(_due + period, now - period)
	_asked = _frame_before if _is_window else now
	_picture.ask()


func _on_frame_drawn() -> void:
	if _asked == 0 or not _connected:
		return
	var pixels := _picture.take()
	_carrier.put_picture(Wire.video_head(_pictures, _stamp(_asked), width, height), pixels)
	_pictures += 1
	_asked = 0


# An adapter that does not say what time it is goes by when things arrive.
func _stamp(usec: int) -> int:
	return usec if _clock.known else 0
