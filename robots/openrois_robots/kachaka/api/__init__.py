"""The robot's API over gRPC: calls with deadlines, long polls, and commands whose ends are matched by their ids."""
