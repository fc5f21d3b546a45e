"""What runs at 1 kHz: servo, supervisor, whole-body control, walking."""
