"""Robots that speak ROS 2 behind RoIS: a mapping file binds their topics and actions to components."""
