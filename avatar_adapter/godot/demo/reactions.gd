# The reactions: for each channel of the figure the moments (s) and values between which it glides, from rest to rest.
#
# Radians: pitch looks down, yaw to the picture's right, lean forward. Of each arm (r, l): raise forward, out to its
# side, elbow forward, bend outward. Others go from 0 to 1; hop and shoulders are metres.
extends Reference

const ALL := {
	"nod": {"seconds": 1.5, "pitch": [0.25, 0.4, 0.5, -0.06, 0.75, 0.34, 1.05, 0.0], "smile": [0.4, 0.5, 1.1, 0.5]},
	"shake_head": {"seconds": 1.8, "yaw": [0.25, -0.45, 0.6, 0.45, 0.95, -0.4, 1.3, 0.3], "brow": [0.4, -0.5, 1.3, -0.5]},
	"tilt": {"seconds": 1.7, "roll": [0.5, 0.38, 1.2, 0.38], "brow": [0.4, 0.8, 1.2, 0.8]},
	"bow": {"seconds": 2.2, "lean": [0.8, 0.75, 1.4, 0.75], "pitch": [0.8, 0.3, 1.4, 0.3]},
	"wave":
	{
		"seconds": 2.6,
		"r_out": [0.5, 1.15, 2.1, 1.15],
		"r_bend": [0.5, 1.5, 0.75, 2.3, 1.0, 1.5, 1.25, 2.3, 1.5, 1.5, 1.75, 2.3, 2.1, 1.6],
		"roll": [0.5, -0.14, 2.1, -0.14],
		"smile": [0.4, 1.0, 2.2, 1.0],
		"brow": [0.4, 0.6, 2.1, 0.4],
	},
	"raise_hand":
	{
		"seconds": 2.4,
		"r_out": [0.6, 2.75, 1.8, 2.75],
		"shoulders": [0.6, 0.02, 1.8, 0.02],
		"brow": [0.4, 0.6, 1.8, 0.5],
		"pitch": [0.6, -0.1, 1.8, -0.1],
	},
	"clap":
	{
		"seconds": 2.2,
		"r_raise": [0.4, 0.75, 1.8, 0.75],
		"l_raise": [0.4, 0.75, 1.8, 0.75],
		"r_elbow": [0.4, 0.9, 1.8, 0.9],
		"l_elbow": [0.4, 0.9, 1.8, 0.9],
		"r_bend": [0.4, -0.1, 0.55, -0.62, 0.75, -0.1, 0.95, -0.62, 1.15, -0.1, 1.35, -0.62, 1.55, -0.1, 1.75, -0.62],
		"l_bend": [0.4, -0.1, 0.55, -0.62, 0.75, -0.1, 0.95, -0.62, 1.15, -0.1, 1.35, -0.62, 1.55, -0.1, 1.75, -0.62],
		"smile": [0.4, 1.0, 1.9, 1.0],
	},
	"shake_hands":
	{
		"seconds": 2.6,
		"r_raise": [0.6, 0.95, 0.85, 1.1, 1.1, 0.85, 1.35, 1.1, 1.6, 0.85, 1.9, 0.95],
		"r_elbow": [0.6, 0.45, 1.9, 0.45],
		"lean": [0.6, 0.16, 1.9, 0.16],
		"smile": [0.5, 0.8, 2.1, 0.8],
	},
	"glance_at_watch":
	{
		"seconds": 2.4,
		"l_raise": [0.6, 0.8, 1.6, 0.8],
		"l_elbow": [0.6, 1.25, 1.6, 1.25],
		"l_bend": [0.6, -0.7, 1.6, -0.7],
		"pitch": [0.6, 0.5, 1.6, 0.5],
		"yaw": [0.6, 0.2, 1.6, 0.2],
		"brow": [0.9, 0.5, 1.6, 0.3],
	},
	"look_around": {"seconds": 3.0, "yaw": [0.6, -0.75, 1.1, -0.75, 1.8, 0.75, 2.3, 0.75], "twist": [0.7, -0.2, 1.9, 0.2]},
	"shrug":
	{
		"seconds": 1.9,
		"shoulders": [0.4, 0.07, 1.1, 0.07],
		"r_out": [0.4, 0.4, 1.1, 0.4],
		"l_out": [0.4, 0.4, 1.1, 0.4],
		"r_elbow": [0.4, 1.2, 1.1, 1.2],
		"l_elbow": [0.4, 1.2, 1.1, 1.2],
		"r_bend": [0.4, 0.6, 1.1, 0.6],
		"l_bend": [0.4, 0.6, 1.1, 0.6],
		"roll": [0.4, 0.2, 1.1, 0.2],
		"brow": [0.4, 1.0, 1.1, 1.0],
	},
	"cheer":
	{
		"seconds": 2.0,
		"hop": [0.35, 0.0, 0.6, 0.22, 0.85, 0.0, 1.1, 0.18, 1.35, 0.0],
		"r_out": [0.5, 2.5, 1.5, 2.5],
		"l_out": [0.5, 2.5, 1.5, 2.5],
		"smile": [0.3, 1.0, 1.7, 1.0],
		"brow": [0.3, 0.8, 1.6, 0.8],
	},
}


# What a reaction adds to a channel, so many seconds after it began.
static func value(reaction: Dictionary, channel: String, at: float) -> float:
	var keys: Array = reaction.get(channel, [])
	var before := 0.0
	var since := 0.0
	for index in range(0, keys.size(), 2):
		if at < keys[index]:
			return lerp(before, keys[index + 1], smoothstep(since, keys[index], at))
		since = keys[index]
		before = keys[index + 1]
	return lerp(before, 0.0, smoothstep(since, reaction["seconds"], at)) if not keys.empty() else 0.0
