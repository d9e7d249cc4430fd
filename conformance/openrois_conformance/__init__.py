"""The requirements of RoIS 2.0 and of the wire, how each is checked, and a suite to try any gateway with."""
