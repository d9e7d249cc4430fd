// Packs a picture as the planes Y, U and V (BT.601, limited range): each pixel written here is four bytes of them, in
// the order in which they go on the wire. What is read back is a third of RGBA8, and no script touches a pixel.
shader_type canvas_item;
// Onto nothing, this leaves all four bytes as they are. (GLES2 mixes where blending is said to be disabled.)
render_mode unshaded, blend_premul_alpha;

uniform sampler2D picture;
uniform vec2 size;
uniform bool bottom_up;

vec4 colour(sampler2D from, vec2 at, vec2 whole, bool turned) {
	vec2 place = at / whole;
	return vec4(texture(from, vec2(place.x, turned ? 1.0 - place.y : place.y)).rgb, 1.0);
}

void fragment() {
	vec2 at = floor(UV * vec2(size.x / 4.0, size.y * 1.5));
	vec2 first = vec2(at.x * 4.0 + 0.5, at.y + 0.5);
	vec2 next = vec2(1.0, 0.0);
	vec4 weights = vec4(0.256788, 0.504129, 0.097906, 0.062745);
	if (at.y >= size.y) {
		// A row here is two rows of a chroma plane; each byte is the mean of four pixels, which the filter makes.
		float row = at.y - size.y;
		weights = vec4(-0.148223, -0.290993, 0.439216, 0.501961);
		if (row >= size.y / 4.0) {
			row -= size.y / 4.0;
			weights = vec4(0.439216, -0.367788, -0.071427, 0.501961);
		}
		float left = at.x * 4.0;
		row *= 2.0;
		if (left >= size.x / 2.0) {
			left -= size.x / 2.0;
			row += 1.0;
		}
		first = vec2(left * 2.0 + 1.0, row * 2.0 + 1.0);
		next = vec2(2.0, 0.0);
	}
	COLOR = vec4(
		dot(colour(picture, first, size, bottom_up), weights),
		dot(colour(picture, first + next, size, bottom_up), weights),
		dot(colour(picture, first + 2.0 * next, size, bottom_up), weights),
		dot(colour(picture, first + 3.0 * next, size, bottom_up), weights)
	);
}
