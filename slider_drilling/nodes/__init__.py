"""ROS 2 nodes around plant, controllers and logs; the only package that imports ROS."""
