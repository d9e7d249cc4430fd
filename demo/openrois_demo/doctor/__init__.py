"""`openrois doctor`: what of the media path works on this machine, and what to change where it does not."""
