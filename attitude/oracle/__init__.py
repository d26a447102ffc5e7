"""Attitude and rate of rigid bodies to any number of digits, independent of the library's own computation.

`truth` has free bodies to fifty digits by two routes, `torque_motion` bodies under torques to thirty by one.
The package needs mpmath (the extra `cost`) and is faster with gmpy2; the tests and `attitude.cost` use it.
"""
