# The moments of the engine link: CLOCK_MONOTONIC, in microseconds.
#
# Godot has a clock of its own, which begins at its start and is not slewed (CLOCK_MONOTONIC_RAW). The adapter's welcome
# says what CLOCK_MONOTONIC was at that moment; from then on the system's time, which is slewed alike, tells how far
# the two drift apart. A system's time that is set jumps, and is then followed from its new value.
extends Reference

const _LOOK_USEC := 250000
const _SHARE := 0.05  # of each look: its resolution is a millisecond
const _JUMP_USEC := 50000

var known := false  # whether an adapter has told the time yet
var _offset := 0.0  # CLOCK_MONOTONIC at the start of Godot's own clock
var _system := 0.0  # the system's time at the start of Godot's own clock, averaged
var _looked_at := 0


func now() -> int:
	return OS.get_ticks_usec() + int(_offset)


# Take over that the time was `monotonic_ns` when Godot's own clock was at `ticks`.
func set_by(monotonic_ns: float, ticks: int) -> void:
	_offset = monotonic_ns / 1000.0 - ticks
	_system = _system_now()
	known = true


# Called once per frame.
func follow() -> void:
	if OS.get_ticks_usec() - _looked_at < _LOOK_USEC:
		return
	_looked_at = OS.get_ticks_usec()
	var drift := _system_now() - _system
	if abs(drift) > _JUMP_USEC:
		_system += drift
	else:
		_system += drift * _SHARE
		_offset += drift * _SHARE


func _system_now() -> float:
	return OS.get_system_time_msecs() * 1000.0 - OS.get_ticks_usec()
