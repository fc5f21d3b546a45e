"""What a model tells of a robot that nobody has described: limbs, soles, drives, posture."""
