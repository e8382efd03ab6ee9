"""The validator: checks that try to break a task, one function each, and their report."""
