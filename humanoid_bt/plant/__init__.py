"""What the servo drives: a robot in a scene, in MuJoCo."""
