"""Takes the pictures of the documentation from the real page, and says which of them are out of date."""
