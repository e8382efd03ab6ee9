"""Arms and grippers as their makers publish them, in forms of our own."""
