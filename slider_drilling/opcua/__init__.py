"""A rig's OPC UA server as a source of samples and a sink of commands. It imports no ROS."""
