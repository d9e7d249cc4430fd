"""What RoIS 2.0 and the wire require, how each requirement is checked, and a suite to try any gateway with."""
