"""What a robot is: robot.yaml and the model."""
