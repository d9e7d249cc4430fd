"""Speech: text in, sound and mouth shapes out, by one of several synthesizers, and the voice that plays them.

`contract` says what a synthesizer does.
`espeak_child` is the only module that loads the GPL library, and it runs only as a process; `synthesizer` talks to it.
"""
