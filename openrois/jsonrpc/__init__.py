"""JSON-RPC 2.0, both ways over one connection: the protocol without input or output, and the session that runs it."""
