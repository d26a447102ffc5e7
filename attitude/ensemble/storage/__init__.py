"""Where the attitudes of an ensemble are stored: Zarr or Parquet, chunk by chunk."""
