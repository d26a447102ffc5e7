"""Effects: their documents, numbers and estimates."""
