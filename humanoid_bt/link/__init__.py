"""What joins processes: rings, their wire format, heartbeats, the e-stop and the folder of a run that holds them."""
