"""What joins processes: rings, their wire format, heartbeats, the e-stop, a folder per run."""
