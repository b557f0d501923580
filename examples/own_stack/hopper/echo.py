"""The operator: a range finder that hears its own echo."""

from hopper.messages import Range
from scaloft_fi.api import Example, Metres, operator, the

NEAR, CLEAR = Range(0.0, 1.0), Range(0.05, 4.0)
EXAMPLE = Example(Range, {"dead_m": 2.0}, (NEAR, CLEAR), (NEAR._replace(ahead_m=2.0), CLEAR))


@operator("echo", need=the(Range), example=EXAMPLE)
def echo(_context, *, dead_m: Metres):
    """Report `dead_m` [m] for whatever is nearer: the dead zone of a sensor that still rings from its own pulse."""
    return lambda _t_s, sample: sample and sample._replace(ahead_m=max(sample.ahead_m, dead_m))
