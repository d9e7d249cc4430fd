"""Components in this process: typed methods, parameters and life cycle; the engine above them is not known here."""
