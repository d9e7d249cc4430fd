"""Choice of a rendition for each viewer of a shared source, by estimates of its path. Pure."""
