"""PostgreSQL as what gateways share: connections that come back, a schema with versions, and what is kept in it."""
