"""A mind that a language model at a server is, by an API like OpenAI's chat completions."""
