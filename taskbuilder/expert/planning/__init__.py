"""Motion planning: paths of several arms at once, free of collisions and timed."""
