"""What it costs that gateways are several."""
