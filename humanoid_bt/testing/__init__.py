"""The testing kit: a simulated robot for tests of one skill."""
