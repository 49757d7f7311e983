"""The live page: what it shows, how it looks, who may see it. It imports no ROS; `nodes.dashboard` feeds it."""
