"""From the Pydantic models to JSON Schema, OpenRPC, TypeScript, C# and Python: `make generate` writes it all."""
