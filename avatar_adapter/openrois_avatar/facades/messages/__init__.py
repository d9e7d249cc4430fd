"""The signaling messages of game engines that do WebRTC themselves, checked when they are read. Pure."""
