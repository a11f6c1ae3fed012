"""Where a controller's numbers and states lie in its vectors; four axes: north, east, down and heading."""

AXES = 4
# Numbers: gains of surge, sway, heave and yaw; masses and linear damping fed forward; the reference's frequencies
# and limits, along and turning; radius and angle of arrival; counts; the setpoint; waypoints.
PROPORTIONAL, INTEGRAL, DERIVATIVE, MASS, DAMPING = range(0, 20, 4)
(PATH_FREQUENCY, MAX_SPEED, MAX_ACCELERATION, TURN_FREQUENCY, MAX_RATE, MAX_TURN_ACCELERATION, RADIUS, ANGLE,
 REPEATS, COUNT, SETPOINT) = range(20, 31)  # fmt: skip
WAYPOINTS = SETPOINT + AXES
# Of a waypoint: position and heading (4), time to stay [s], speed [m/s].
STAY, SPEED, WAYPOINT = 4, 5, 6
# States: the reference's position, velocity and acceleration with heading, rate and its rate (4 each), the integral
# load in the world's frame, the demand before limits in the body's, which waypoint, and since when it is reached.
PLACE, RATE, CHANGE, LOAD, ASKED, LEG, SINCE, STATES = 0, 4, 8, 12, 16, 20, 21, 22
NOT_THERE = -1e300
