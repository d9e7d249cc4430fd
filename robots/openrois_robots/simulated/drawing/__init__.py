"""How the robot's camera sees the simulated rooms: meshes, textures, and Panda3D's software renderer."""
