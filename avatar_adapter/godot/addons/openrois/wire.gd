# The frames of the engine link: bytes out and bytes in, nothing else. docs/reference/engine-link.md describes every byte.
extends Reference

enum {HELLO = 1, WELCOME, VIDEO, AUDIO, COMMAND, EVENT, BYE}

const HEADER := 16
const MAX_PAYLOAD := 65536  # of whatever an adapter sends
const SOUND_HEAD := 24  # bytes before the samples of AUDIO
const _MAGIC := 0x314C524F  # "ORL1", the lowest byte first
const _VERSION := 1
const _I420 := 2


# A message that is a JSON object.
static func json(type: int, body: Dictionary) -> PoolByteArray:
	var payload := to_json(body).to_utf8()
	var bytes := _header(type, payload.size()).data_array
	bytes.append_array(payload)
	return bytes


# What stands before the pixels of an I420 picture, top row first and without padding.
static func video_head(sequence: int, usec: int, width: int, height: int) -> PoolByteArray:
	var head := _header(VIDEO, 40 + width * height * 3 / 2)
	head.put_u64(sequence)
	head.put_u64(usec * 1000)
	for number in [width, height, width, _I420, 0, 0]:
		head.put_u32(number)
	return head.data_array


# A block of mono sound, signed 16 bit at 48 kHz.
static func audio(sequence: int, usec: int, samples: PoolByteArray) -> PoolByteArray:
	var head := _header(AUDIO, SOUND_HEAD + samples.size())
	head.put_u64(sequence)
	head.put_u64(usec * 1000)
	head.put_u32(1)
	head.put_u32(0)
	var bytes := head.data_array
	bytes.append_array(samples)
	return bytes


static func _header(type: int, length: int) -> StreamPeerBuffer:
	var head := StreamPeerBuffer.new()
	head.put_u32(_MAGIC)
	head.put_u8(type)
	head.put_u8(_VERSION)
	head.put_u16(0)
	head.put_u32(length)
	head.put_u32(0)
	return head


# Cuts what an adapter sends into messages.
class Parser:
	var fault := ""  # what was wrong; nothing is read after that
	var _bytes := PoolByteArray()

	# The messages that are complete now, each [type, payload].
	func feed(data: PoolByteArray) -> Array:
		_bytes.append_array(data)
		var stream := StreamPeerBuffer.new()
		stream.data_array = _bytes
		var messages := []
		var at := 0
		while fault == "" and _bytes.size() - at >= HEADER:
			stream.seek(at)
			var magic := stream.get_u32()
			var type := stream.get_u8()
			var version := stream.get_u8()
			var flags := stream.get_u16()
			var length := stream.get_u32()
			var reserved := stream.get_u32()
			if magic != _MAGIC or version != _VERSION or flags != 0 or reserved != 0:
				fault = "the adapter does not speak version 1 of the engine link"
			elif not type in [WELCOME, AUDIO, COMMAND, BYE] or length > MAX_PAYLOAD:
				fault = "the adapter sent what only an engine may send, or too much"
			elif _bytes.size() - at - HEADER < length:
				break
			else:
				var end := at + HEADER + length
				messages.append([type, _part(at + HEADER, end)])
				at = end
		if at > 0:
			_bytes = _part(at, _bytes.size())
		return messages

	func _part(from: int, end: int) -> PoolByteArray:
		return _bytes.subarray(from, end - 1) if end > from else PoolByteArray()
