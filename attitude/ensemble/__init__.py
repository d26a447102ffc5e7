"""Many bodies: drawn about a scene or read from a table, moved, and told as statistics or stored."""
