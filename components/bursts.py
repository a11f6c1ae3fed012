"""What comes and goes in bursts, such as a signal: a Markov chain of two states in continuous time."""

from math import exp

from components.compiled import kernel


@kernel
def probability_lost(was_lost, visible_time, lost_time, h):
    """Probability that a marker or signal is lost h [s] after it was (was_lost 1) or was not (0).

    visible_time, lost_time: mean sojourns [s], exponentially distributed; h infinite gives the stationary share.
    Exact for any h: the solution of Kolmogorov's forward equation for two states, so that the drop-outs' statistics do
    not depend on the sampling rate. A loss shorter than h may pass between two samples unseen.
    """
    if lost_time <= 0.0:
        return 0.0
    share = lost_time / (visible_time + lost_time)
    remembered = exp(-h / visible_time - h / lost_time)
    return share + (was_lost - share) * remembered
