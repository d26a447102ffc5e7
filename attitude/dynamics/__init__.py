"""What happens to a body: numbers in, attitudes in time out.  Knows neither units nor documents."""
