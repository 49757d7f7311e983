"""Many virtual rigs at once as gymnasium environments, for those who train controllers."""
