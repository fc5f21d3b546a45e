"""The house: the rooms of the package as the code has them, the ways through it, and the pictures of both."""
