"""The component contract over a connection: `RemoteProxy` on one end, `serve_engine` on the other, tested as a pair."""
