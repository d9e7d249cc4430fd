"""Reading component classes: from decorated methods with type hints to a component type, its profile and its calls.

Pure.
"""
