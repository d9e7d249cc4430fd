"""A simulated Kachaka on the vendor's gRPC servicer: a testing tool, `python -m openrois_robots.kachaka.simulator`.

It shows that calls, cursors and pictures fit the vendor's own client. How a real robot behaves (its times, its error
codes, whether it speaks while it drives) is our reading of that client, and no evidence.
"""
