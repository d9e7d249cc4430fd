"""What every sense of the avatar shares: when it works, and what of its findings is worth telling. Pure."""
