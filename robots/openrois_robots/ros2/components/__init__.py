"""Components of a robot that speaks ROS 2, as far as they are not those of every robot."""
