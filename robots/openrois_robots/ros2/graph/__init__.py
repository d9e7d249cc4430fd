"""The graph of ROS 2 as an adapter needs it: names, quality of service, and the contract of what reaches it."""
