# Pictures of a viewport for the link: I420, converted by a shader, read back on request.
extends Viewport

var width: int
var height: int


# `new_width` is a multiple of 8 and `new_height` of 4: only then are the planes whole rows of what is drawn here.
func _init(new_width: int, new_height: int) -> void:
	width = new_width
	height = new_height
	size = Vector2(width / 4, height * 3 / 2)
	usage = USAGE_2D
	disable_3d = true
	transparent_bg = true  # else there would be no fourth byte
	gui_disable_input = true
	render_target_update_mode = UPDATE_DISABLED
	render_target_v_flip = true


func watch(source: Viewport) -> void:
	var texture := source.get_texture()
	texture.flags = Texture.FLAG_FILTER
	var material := ShaderMaterial.new()
	material.shader = preload("i420.shader")
	material.set_shader_param("picture", texture)
	material.set_shader_param("size", Vector2(width, height))
	material.set_shader_param("bottom_up", not source.render_target_v_flip)
	var screen := ColorRect.new()
	screen.rect_size = size
	screen.material = material
	add_child(screen)
	# The server draws a viewport before its parent: the picture is converted in the frame in which it is drawn.
	VisualServer.viewport_set_parent_viewport(source.get_viewport_rid(), get_viewport_rid())


# Let the next frame be converted.
func ask() -> void:
	render_target_update_mode = UPDATE_ONCE


# The picture that was asked for; call it after the frame was drawn.
func take() -> PoolByteArray:
	return get_texture().get_data().get_data()
