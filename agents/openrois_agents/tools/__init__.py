"""The verbs of an agent that has a body: arguments, limits and answers, whatever protocol carries them."""
