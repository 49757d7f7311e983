"""Thin rclpy shells around plant, controllers and logs: the only place where ROS is imported."""
