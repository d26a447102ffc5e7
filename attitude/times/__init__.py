"""Instants: astropy Time to and from two-part seconds since an epoch, ISO 8601 dates, leap seconds, exact sums."""
