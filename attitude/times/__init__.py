"""Instants as two-part seconds since an epoch, from and to astropy Time; ISO 8601 dates; leap seconds."""
