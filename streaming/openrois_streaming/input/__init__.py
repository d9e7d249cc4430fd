"""What a person does with keyboard, mouse, touch and gamepad, as an application tells it. Pure."""
