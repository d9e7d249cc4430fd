"""One application at one engine: its bindings, subscriptions, commands and streams; its methods are in `interfaces`."""
