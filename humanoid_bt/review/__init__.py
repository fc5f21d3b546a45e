"""Looking back at a run from its recording: why it stopped, what it did, how others differ."""
