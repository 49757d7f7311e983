"""The live page: what it shows, how it looks, who may see it. No ROS in here; `nodes.dashboard` feeds it."""
