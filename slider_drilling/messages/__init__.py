"""What nodes publish and logs hold: topics, message types and CDR bytes. Needs no ROS."""
