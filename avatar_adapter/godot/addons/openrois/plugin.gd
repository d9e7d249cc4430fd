# Puts the add-on's nodes into the editor's list.
tool
extends EditorPlugin

const NODES := {
	"OpenRoISLink": preload("link.gd"),
	"OpenRoISMouth": preload("mouth.gd"),
	"OpenRoISWalker": preload("walker.gd"),
	"OpenRoISHands": preload("hands.gd"),
}


func _enter_tree() -> void:
	for name in NODES:
		add_custom_type(name, "Node", NODES[name], null)


func _exit_tree() -> void:
	for name in NODES:
		remove_custom_type(name)
