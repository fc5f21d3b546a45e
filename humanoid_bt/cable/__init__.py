"""A plant in another process: frames between control and it, and what each end does."""
