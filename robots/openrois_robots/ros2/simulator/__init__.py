"""A simulated robot that speaks ROS 2 over Cyclone DDS, for tests of adapters and mapping files."""
