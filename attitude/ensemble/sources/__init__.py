"""Sources of the bodies of an ensemble: dispersions about a scene's body, or rows of a table."""
