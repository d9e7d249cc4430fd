# Sound for the link, in blocks that leave ahead of their time.
#
# Godot 3.2 cannot give what its audio buses play to a script (AudioEffectCapture came with 3.3), so what shall be heard
# at the other end is played here: samples that a script has made or read. Signed 16 bit, mono, 48 kHz.
extends Reference

const RATE := 48000
const BLOCK := 960  # samples: 20 ms
const BLOCK_USEC := 20000
const AHEAD_USEC := 100000
const MAX_PLAYING := 16

var _start := 0  # usec: the moment of sample 0
var _next := 0  # the number of the next block
var _playing := []  # each [first sample, bytes]
var _silence := PoolByteArray()


func _init() -> void:
	_silence.resize(2 * BLOCK)
	for index in _silence.size():
		_silence[index] = 0


# Begin a stream of sound.
func begin(now: int) -> void:
	_start = now
	_next = 0
	_playing = []


# Play samples from the moment `at` on, or as soon as possible; the moment at which they are heard, in usec.
func play(samples: PoolByteArray, at := 0) -> int:
	var first := int(max(_next * BLOCK, round((at - _start) * (RATE / 1e6))))
	_playing.append([first, samples])
	if _playing.size() > MAX_PLAYING:
		_playing.pop_front()
	return _start + int(first * (1e6 / RATE))


# End everything that plays.
func hush() -> void:
	_playing = []


# The blocks that are due to leave, each [usec, samples].
func due(now: int) -> Array:
	var newest := (now - _start) / BLOCK_USEC
	_next = int(max(_next, newest))  # a game that stood still for a while does not make up for it
	var blocks := []
	while _start + _next * BLOCK_USEC - AHEAD_USEC <= now:
		blocks.append([_start + _next * BLOCK_USEC, _block(_next * BLOCK)])
		_next += 1
	return blocks


func _block(first: int) -> PoolByteArray:
	var parts := []
	for index in range(_playing.size() - 1, -1, -1):
		var begin: int = _playing[index][0]
		var samples: PoolByteArray = _playing[index][1]
		if begin + samples.size() / 2 <= first:
			_playing.remove(index)
		elif begin < first + BLOCK:
			parts.append(_cut(samples, first - begin))
	if parts.empty():
		return _silence
	return parts[0] if parts.size() == 1 else _mixed(parts)


# BLOCK samples from `from` on; what is not there is silence.
func _cut(samples: PoolByteArray, from: int) -> PoolByteArray:
	var block := PoolByteArray()
	if from < 0:
		block = _silence.subarray(0, -2 * from - 1)
		from = 0
	var wanted := 2 * BLOCK - block.size()
	var end := int(min(2 * from + wanted, samples.size()))
	block.append_array(samples.subarray(2 * from, end - 1))
	if block.size() < 2 * BLOCK:
		block.append_array(_silence.subarray(block.size(), 2 * BLOCK - 1))
	return block


func _mixed(parts: Array) -> PoolByteArray:
	var streams := []
	for part in parts:
		var stream := StreamPeerBuffer.new()
		stream.data_array = part
		streams.append(stream)
	var mixed := StreamPeerBuffer.new()
	mixed.resize(2 * BLOCK)
	for _sample in BLOCK:
		var sum := 0
		for stream in streams:
			sum += stream.get_16()
		mixed.put_16(int(clamp(sum, -32768, 32767)))
	return mixed.data_array
