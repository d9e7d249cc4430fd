"""ROS 2 interface definitions: messages, services and actions, as texts and as types."""
