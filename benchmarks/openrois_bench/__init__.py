"""Benchmarks of the product: its costs and delays, beside other programs on the same machine.

`openrois bench` has those for any machine; the programs `python -m openrois_bench....` of `benchmarks/README.md` have
those that the documents quote. The product imports nothing of this package.
"""
