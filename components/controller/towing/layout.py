"""Where the towing controller's numbers, inputs and states lie in their vectors."""

# Numbers: switches; the formation; steering; speed; the vessel; propellers; the line; then the path's pieces.
(TAKES_PARTNER, TAKES_LINE, OFFSET, SPEED, MAX_SPEED, GATHERING, LOOKAHEAD, INTEGRAL, DRIFT_TIME, TURNING, YAW_GAIN,
 YAW_DAMPING, MAX_TURN_RATE, SURGE_GAIN, SURGE_INTEGRAL, MAX_ACCELERATION, SURGE_MASS, SURGE_DAMPING, SQUARE_DAMPING,
 ARM, AHEAD, ASTERN, LINE_SHARE, HOOK, HOOK_Y, RADIUS, IS_CLOSED, WAY, COUNT, PIECES) = range(30)  # fmt: skip
# Inputs: own position (2), heading, velocity (2), yaw rate; then the partner's position (2) and the line's force (3).
PLACE, HEADING, VELOCITY, YAW_RATE, OTHERS = 0, 2, 3, 5, 6
# States: own piece, rounds made, the partner's piece, the way that the boat is ahead of it, the steering's integral
# [m], the drift's angle, the speed along the path being asked for, the integral thrust, both propellers' thrust.
OWN, ROUNDS, PARTNER, GAP, WANDERED, DRIFT, ASKED, STEADY, THRUST, STATES = 0, 1, 2, 3, 4, 5, 6, 7, 8, 10
# Scratch: what is written besides: heading and speed asked for, errors across, of heading and of speed, way, flags.
(COURSE, PACE, ACROSS, HEADING_ERROR, SPEED_ERROR, PROGRESS, IS_LIMITED, IS_HELD, IS_ALONE, ARRIVED,
 SCRATCH) = range(11)  # fmt: skip
