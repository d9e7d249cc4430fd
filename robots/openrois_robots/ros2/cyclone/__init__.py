"""A graph of ROS 2 over Eclipse Cyclone DDS alone, without ROS: what `rmw_cyclonedds_cpp` puts on the wire."""
