"""What the adapter of every robot has: options, a process, the link to the robot, its battery."""
