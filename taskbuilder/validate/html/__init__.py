"""Reports as pages that hold all that they show; templates and style sheet lie beside the code."""
