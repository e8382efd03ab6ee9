"""The world: a scene, built. Robots, objects and sites by name, one read a control step."""
