"""The version of the distribution, read by the build and shown by `openrois --version`."""

__version__ = "0.2.0"
