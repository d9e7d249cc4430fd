# What the mouth does while the avatar speaks: gives the weight of each of the fifteen visemes at any moment.
#
# Set `link` to the OpenRoISLink and call weights() in each frame; your character's blend shapes take what it returns.
extends Node

const SHAPES := ["sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "ih", "oh", "ou"]
const SPREAD := 0.11  # seconds over which one shape turns into the next
const EARLY := 0.02  # seconds by which lips are ahead of the sound
const CUT := 0.08  # seconds in which a mouth that is told to be silent closes
const LOUD := 0.12  # the level, 1 being full scale, at which the operator's voice opens the mouth wholly
const _FADE := 0.12  # seconds

export(NodePath) var link := NodePath()

var _link: Node = null
var _tracks := []
var _level := 0.0  # of the operator's voice
var _heard_at := 0


func _ready() -> void:
	_link = get_node(link)
	_link.connect("speak", self, "_on_speak")
	_link.connect("silence", self, "_on_silence")
	_link.connect("disconnected", self, "_on_disconnected")
	_link.connect("heard", self, "_on_heard")


# The weights of the visemes now, by their names; those that are 0 are left out.
func weights() -> Dictionary:
	var now: int = _link.now_usec()
	var sum := {}
	for index in range(_tracks.size() - 1, -1, -1):
		var track: Track = _tracks[index]
		if track.is_over(now):
			_tracks.remove(index)
		else:
			track.add_to(sum, now)
	if sum.empty():
		var opened := _level * max(0.0, 1.0 - (now - _heard_at) / (_FADE * 1e6))
		if opened > 0.02:
			sum["aa"] = opened
	return sum


func _on_speak(_id: String, start_usec: int, visemes: Array, duration_usec: int) -> void:
	_tracks.append(Track.new(start_usec, visemes, duration_usec))


func _on_silence() -> void:
	for track in _tracks:
		track.cut(_link.now_usec())


func _on_disconnected(_reason: String) -> void:
	_on_silence()


func _on_heard(samples: PoolByteArray) -> void:
	var stream := StreamPeerBuffer.new()
	stream.data_array = samples
	var loudest := 0
	for at in range(0, samples.size() - 1, 32):  # one of 16 samples says enough
		stream.seek(at)
		loudest = int(max(loudest, abs(stream.get_16())))
	_level = clamp(loudest / 32768.0 / LOUD, 0.0, 1.0)
	_heard_at = _link.now_usec()


# One `speak`.
class Track:
	var _start: int
	var _visemes := []  # of [begin in seconds, end in seconds, shape, weight]
	var _first := 0  # those before it are over
	var _cut := 0

	func _init(start: int, visemes: Array, duration: int) -> void:
		_start = start
		for index in visemes.size():
			var begin: float = visemes[index][0] / 1000.0
			var end: float = visemes[index + 1][0] / 1000.0 if index + 1 < visemes.size() else duration / 1e6
			_visemes.append([begin, end, visemes[index][1], visemes[index][2]])

	func cut(now: int) -> void:
		if _cut == 0:
			_cut = now

	func is_over(now: int) -> bool:
		return now > _cut + CUT * 1e6 if _cut != 0 else _first >= _visemes.size()

	func add_to(sum: Dictionary, now: int) -> void:
		var at := (now - _start) / 1e6 + EARLY
		var loudness := 1.0 if _cut == 0 else 1.0 - smoothstep(0.0, CUT, (now - _cut) / 1e6)
		while _first < _visemes.size() and _visemes[_first][1] + SPREAD / 2 < at:
			_first += 1
		for index in range(_first, _visemes.size()):
			var viseme: Array = _visemes[index]
			if viseme[0] - SPREAD / 2 > at:
				break
			var weight: float = (_risen(at - viseme[0]) - _risen(at - viseme[1])) * viseme[3] * loudness
			if weight > 0.0:
				sum[viseme[2]] = min(1.0, sum.get(viseme[2], 0.0) + weight)

	static func _risen(since: float) -> float:
		return smoothstep(-SPREAD / 2, SPREAD / 2, since)
