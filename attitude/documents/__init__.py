"""Fields of JSON documents: strict numbers and text, and quantities beside their units."""
