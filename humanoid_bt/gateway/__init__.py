"""What speaks ROS 2 for a run, in a process of its own: percepts and stops in, states out."""
