"""What runs at 1 kHz: the supervisor, the servo, and the body that balances and walks."""
