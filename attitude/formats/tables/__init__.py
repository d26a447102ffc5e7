"""Formats of rows and columns: CSV, JSON, NDJSON, ECSV, FITS; tables of astropy, pandas and xarray."""
