"""Reception of an application's microphone and camera, as media sources."""
