"""Scripts: the stages of a task file, checked by a dry run, carried out, played as a policy."""
