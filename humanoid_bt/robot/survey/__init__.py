"""What a model tells of a robot that nobody has described yet: limbs, soles, drives, posture."""
