# Sounds made by arithmetic: signed 16 bit, mono, 48 kHz.
extends Reference

const RATE := 48000
const _LEVEL := 5000.0


# A soft bell.
static func note(frequency: float, seconds := 0.6) -> PoolByteArray:
	var sound := StreamPeerBuffer.new()
	# A rotating arrow makes the sine, which is cheaper than asking for one.
	var arrow := Vector2(_LEVEL, 0).rotated(-PI / 2)
	var turn := TAU * frequency / RATE
	var cosine := cos(turn)
	var sine := sin(turn)
	var fade := pow(0.002, 1.0 / (seconds * RATE))
	var rise := 1.0
	for _index in int(seconds * RATE):
		arrow = Vector2(cosine * arrow.x - sine * arrow.y, sine * arrow.x + cosine * arrow.y) * fade
		rise *= 0.995
		sound.put_16(int(arrow.x * (1.0 - rise)))
	return sound.data_array


# A foot that is set down.
static func step() -> PoolByteArray:
	var sound := StreamPeerBuffer.new()
	var chance := RandomNumberGenerator.new()
	chance.seed = 7
	var soft := 0.0
	var level := _LEVEL * 2.0
	for _index in RATE / 12:
		soft += (chance.randf_range(-1.0, 1.0) - soft) * 0.06
		sound.put_16(int(soft * level))
		level *= 0.9988
	return sound.data_array
