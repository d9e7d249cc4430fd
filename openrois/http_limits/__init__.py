"""Bounds on HTTP connections before and below a request: header time, connections, WebSocket frames."""
