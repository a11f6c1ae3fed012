"""Speed of a drum between its limits."""

from components.compiled import kernel


@kernel
def wanted(speed, tension, max_speed, stall_tension):
    """The rate [m/s] nearest to the command that the motor can hold against the tension [N].

    A motor of constant voltage hauls in at max_speed (1 - T / T_stall), and is dragged the other way above T_stall.
    """
    return min(max(speed, -max_speed, max_speed * (tension / stall_tension - 1.0)), max_speed)


@kernel
def advance(rate, stored, target, max_acceleration, h):
    """Rate [m/s] and stored line [m] after h [s], the rate going evenly towards the target; an empty drum stops."""
    reach = max_acceleration * h
    after = rate + min(max(target - rate, -reach), reach)
    left = stored - 0.5 * h * (rate + after)
    if left <= 0.0:
        return 0.0, 0.0
    return after, left
