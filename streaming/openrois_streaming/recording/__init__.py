"""Received media in files: JPEG, and MP4, WebM and WAV by PyAV."""
