"""Operator input from keyboard, mouse, touch and gamepad, as messages of an application. Pure."""
