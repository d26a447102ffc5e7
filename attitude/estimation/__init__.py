"""The motion of a free body from observations of it.

observations        attitudes, body rates, directions and ranges, with their residuals and derivatives
parameters          what is estimated, as numbers; the motion of given numbers, and its derivatives by them
least_squares       the weighted sum of squares of all observations, reduced to a small triangular problem
starts              where the search begins when no start is given
minimum             a minimum of the sum of squares, and the answer there
fit                 the fit, and warnings of what makes its answer doubtful
fit_result          what it returns
observability       which directions of the parameters the data see
residuals           observed less computed
gaps                gaps of an ephemeris filled by the motion that fits both sides
observation_table   observations in CSV files with units in the names of the columns
fit_document        a scene's document with its observations
plot                pictures of residuals
"""

from .observations import Attitudes as Attitudes
from .observations import BodyRates as BodyRates
from .observations import Directions as Directions
from .observations import RangeOffsets as RangeOffsets

__all__ = ["Attitudes", "BodyRates", "Directions", "RangeOffsets"]
