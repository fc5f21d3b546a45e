"""The learned body: a network walks and balances, inverse kinematics moves what it lends."""
