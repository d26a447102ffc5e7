"""Attitude and rate of rigid bodies to as many digits as asked for, by routes independent of ours.

Free bodies to fifty digits by two routes (`truth`), bodies under torques to thirty by one (`torqued`).
Needs mpmath (the extra `cost`), is quicker with gmpy2, and serves the tests and `attitude.cost`.
"""
