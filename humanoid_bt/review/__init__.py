"""Looking back at a run from its recording: why it stopped, how it differs from another."""
