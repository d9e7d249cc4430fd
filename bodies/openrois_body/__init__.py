"""Senses, speech, motion and teleoperation of every body, avatar or robot; it knows no engine and no middleware."""
