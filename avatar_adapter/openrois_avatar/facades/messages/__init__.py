"""The signaling messages of game engines that do WebRTC themselves, checked on the way in. Pure."""
