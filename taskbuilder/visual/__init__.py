"""Pictures of worlds and robots, films and strips of episodes, charts and learning curves."""
