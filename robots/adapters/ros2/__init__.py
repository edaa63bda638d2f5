"""Robots that are driven by ROS 2 actions. Runs beside ROS 2, whose packages it imports when it is started."""
