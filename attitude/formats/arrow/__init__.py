"""Arrow files and streams, and Parquet."""
