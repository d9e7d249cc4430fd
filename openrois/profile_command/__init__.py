"""`openrois profile`: profiles out of a gateway or the catalog into files, and out of files into JSON."""
