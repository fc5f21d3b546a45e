"""What every room shares: messages, the clock, errors with places, declared parameters."""
