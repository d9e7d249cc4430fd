"""The room of the embedded engines' figure: floor and furniture, the visitor, walking, and the camera.

Pure: times are seconds on one clock, places are metres and radians as on the engine link.
"""
