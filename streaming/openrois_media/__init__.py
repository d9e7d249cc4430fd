"""RoIS Streaming Interface of an adapter, with health and figures of its sources; it knows no body."""
