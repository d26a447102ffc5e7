"""Where the bodies of an ensemble come from: dispersions about a scene, or rows of a table."""
