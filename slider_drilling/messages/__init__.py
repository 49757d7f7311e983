"""What nodes publish and logs hold: topics, schemas, and CDR bytes. No ROS needed."""
