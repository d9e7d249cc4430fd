"""Logs, the audit trail and health; what is measured is in `metrics`."""
