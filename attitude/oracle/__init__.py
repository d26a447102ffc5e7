"""Attitude and rate of torque-free bodies to fifty digits, by routes independent of the library's own.

Needs mpmath (the extra `cost`), is quicker with gmpy2, and serves the tests and `attitude.cost`.
"""
