"""Numbers of Julian dates: the length of a day, J2000.0, and day 0 of modified Julian dates."""

DAY = 86400.0  # s
J2000 = 2451545.0
MJD = 2400000.5
