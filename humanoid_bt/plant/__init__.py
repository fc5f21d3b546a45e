"""The thing the servo drives: a robot in MuJoCo, its scene, and simulated perception."""
