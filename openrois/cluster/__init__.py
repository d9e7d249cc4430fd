"""Several gateways as one: message streams over NATS, ownership and records in PostgreSQL."""
