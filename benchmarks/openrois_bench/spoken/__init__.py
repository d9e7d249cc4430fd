"""Speech of the avatar and speech to it: delays of words, and recognition rates."""
