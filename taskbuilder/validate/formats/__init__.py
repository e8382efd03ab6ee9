"""Reports for machines, JUnit and GitHub, and the words that all formats share."""
