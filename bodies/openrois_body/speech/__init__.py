"""Speech: text in, sound and mouth shapes out, by espeak-ng in a process of its own, and the voice that plays them.

`espeak_child` is the only module that loads the GPL library, and it runs only as a process; `synthesizer` talks to it.
"""
