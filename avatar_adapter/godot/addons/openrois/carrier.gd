# One connection to the adapter. A thread connects, greets and writes, so that the game never waits; the game's own
# thread reads, which takes no time. Of pictures only the newest is kept, of sound half a second, of events all.
extends Reference

const Wire := preload("wire.gd")

const GREETING_MSEC := 5000
const STALL_MSEC := 10000  # after which an adapter that reads nothing counts as gone
const FAREWELL_MSEC := 500
const MAX_EVENTS := 256
const MAX_SOUNDS := 25

var welcome := {}  # what the adapter said, once it has
var welcomed_at := 0  # when it did, as OS.get_ticks_usec() has it

var _host: String
var _port: int
var _hello: PoolByteArray
var _peer := StreamPeerTCP.new()
var _socket := Mutex.new()  # held for every use of _peer; none of them waits
var _parser := Wire.Parser.new()
var _read_early := []  # what came with the welcome
var _thread := Thread.new()
var _mutex := Mutex.new()  # for everything below
var _wake := Semaphore.new()
var _open := false
var _reason := ""  # why it is over
var _give_up_at := 0  # msec; 0 while it is not to end
var _events := []
var _sounds := []
var _picture := []  # head and pixels of the newest one


func _init(host: String, port: int, hello: PoolByteArray) -> void:
	_host = host
	_port = port
	_hello = hello


func start() -> void:
	_thread.start(self, "_run")


# Whether the adapter has welcomed us.
func is_open() -> bool:
	_mutex.lock()
	var answer := _open
	_mutex.unlock()
	return answer


# Why the connection is over; empty while it is not.
func reason() -> String:
	_mutex.lock()
	var answer := _reason
	_mutex.unlock()
	return answer


# The messages that have arrived, each [type, payload].
func receive() -> Array:
	var messages := _read_early
	_read_early = []
	messages += _read()
	return messages


func put_event(event: PoolByteArray) -> void:
	_mutex.lock()
	_events.append(event)
	var full := _events.size() > MAX_EVENTS
	_mutex.unlock()
	if full:
		fail("the adapter does not read: too many events wait")
	_wake.post()


func put_sound(block: PoolByteArray) -> void:
	_mutex.lock()
	_sounds.append(block)
	if _sounds.size() > MAX_SOUNDS:
		_sounds.pop_front()
	_mutex.unlock()
	_wake.post()


func put_picture(head: PoolByteArray, pixels: PoolByteArray) -> void:
	_mutex.lock()
	_picture = [head, pixels]
	_mutex.unlock()
	_wake.post()


# Say that the connection is over; the first reason stays.
func fail(reason: String) -> void:
	_mutex.lock()
	if _reason == "":
		_reason = reason
	_mutex.unlock()
	_wake.post()


# End the connection. With a farewell, what waits is sent and then the farewell, for half a second at most.
func close(farewell := "") -> void:
	_mutex.lock()
	var said := _open and _reason == "" and farewell != ""
	_give_up_at = OS.get_ticks_msec() + (FAREWELL_MSEC if said else 0)
	_picture = []
	_sounds = []
	if said:
		_events.append(Wire.json(Wire.BYE, {"reason": farewell}))
	else:
		_reason = "closed" if _reason == "" else _reason
	_mutex.unlock()
	_wake.post()
	if _thread.is_active():
		_thread.wait_to_finish()
	_peer.disconnect_from_host()


# ---- the thread ----

func _run(_nothing) -> void:
	if not _greet():
		return
	while not _ends():
		var parts := _next()
		if parts.empty():
			_wake.wait()
		for part in parts:
			if not _write(part, OS.get_ticks_msec() + STALL_MSEC):
				return


func _greet() -> bool:
	var deadline := OS.get_ticks_msec() + GREETING_MSEC
	if _peer.connect_to_host(_host, _port) != OK:
		fail("cannot connect")
		return false
	while _status() == StreamPeerTCP.STATUS_CONNECTING and OS.get_ticks_msec() < deadline and not _ends():
		OS.delay_msec(1)
	if _status() != StreamPeerTCP.STATUS_CONNECTED:
		fail("no adapter answers; start it, or check the address")
		return false
	_peer.set_no_delay(true)
	if not _write(_hello, deadline):
		return false
	while not _ends():
		var messages := _read()
		if not messages.empty():
			return _take_greeting(messages)
		if OS.get_ticks_msec() > deadline:
			fail("the adapter does not answer")
		OS.delay_usec(500)
	return false


func _take_greeting(messages: Array) -> bool:
	welcomed_at = OS.get_ticks_usec()
	var first: Array = messages.pop_front()
	var body = parse_json(first[1].get_string_from_utf8())
	if first[0] != Wire.WELCOME or not body is Dictionary:
		fail("refused: %s" % [body.get("reason", "") if body is Dictionary else ""])
		return false
	welcome = body
	_read_early = messages
	_mutex.lock()
	_open = true
	_mutex.unlock()
	return true


# What is to be sent next: a list of bytes, empty where there is nothing.
func _next() -> Array:
	var parts := []
	_mutex.lock()
	if not _events.empty():
		parts = [_events.pop_front()]
	elif not _sounds.empty():
		parts = [_sounds.pop_front()]
	elif not _picture.empty():
		parts = _picture
		_picture = []
	_mutex.unlock()
	return parts


# Whether the thread has to end: the connection has ended, or is being closed with nothing left to send.
func _ends() -> bool:
	_mutex.lock()
	var answer := _reason != "" or (_give_up_at != 0 and _events.empty())
	_mutex.unlock()
	return answer


func _write(bytes: PoolByteArray, deadline: int) -> bool:
	var rest := bytes
	while true:
		_socket.lock()
		var outcome := _peer.put_partial_data(rest)
		_socket.unlock()
		if outcome[0] != OK:
			fail("the connection broke")
			return false
		if outcome[1] >= rest.size():
			return true
		if outcome[1] > 0:
			rest = rest.subarray(outcome[1], rest.size() - 1)
		elif OS.get_ticks_msec() > deadline or _given_up():
			fail("the adapter does not read")
			return false
		else:
			OS.delay_usec(300)
	return false


func _given_up() -> bool:
	_mutex.lock()
	var answer := _reason != "" or (_give_up_at != 0 and OS.get_ticks_msec() > _give_up_at)
	_mutex.unlock()
	return answer


# ---- both threads, but never both at a time ----

func _status() -> int:
	_socket.lock()
	var status := _peer.get_status()
	_socket.unlock()
	return status


func _read() -> Array:
	var data := PoolByteArray()
	_socket.lock()
	var waiting := _peer.get_available_bytes() if _peer.is_connected_to_host() else -1
	if waiting > 0:
		data = _peer.get_partial_data(waiting)[1]
	var status := _peer.get_status()
	_socket.unlock()
	var messages: Array = _parser.feed(data) if data.size() > 0 else []
	if _parser.fault != "":
		fail(_parser.fault)
	elif status != StreamPeerTCP.STATUS_CONNECTED and waiting <= 0:
		fail("the adapter closed the connection")
	return messages
