"""Plugins that tests of the project use."""

pytest_plugins = ["pytester"]
