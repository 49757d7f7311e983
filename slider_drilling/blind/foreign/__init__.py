"""Plants of foreign structure: what no file of ours says of a rig, at the sizes that real rigs have."""
