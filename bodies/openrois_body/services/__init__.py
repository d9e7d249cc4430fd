"""Servers of other makers that speak and recognise, by HTTP."""
