"""The gateway, the main HRI engine: the one place that knows every part of the control plane."""
