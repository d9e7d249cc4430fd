"""The engine link: frames, sound, commands and events between a game engine and the avatar adapter.

`protocol` and `messages` do no input or output. `client` is the game engine's side (standard library and NumPy only),
`server`, `embedded` and `external` are the adapter's side (asyncio).
"""
