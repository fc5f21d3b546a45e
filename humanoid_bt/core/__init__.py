"""What every layer shares: messages, the clock, errors with places, declared parameters."""
