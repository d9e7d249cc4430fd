"""Prints the parts of pages that follow from the code: tables of states, options, settings and figures."""
