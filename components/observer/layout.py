"""Where an observer's numbers, inputs and states lie in its vectors."""

# Of the numbers of every observer, see ship.ShipObserver.block.
(REFERENCES, HAS_MRU, HAS_WIND, HAS_THRUST, FROZEN_AFTER, LONGEST_AGE, WIND_TIME, WAVE_FREQUENCY, WAVE_DAMPING,
 BIAS_TIME, BELIEVED_AFTER, FASTEST, START) = range(13)  # fmt: skip
INVERSE, DAMPING, WINDAGE, FIRST = START + 3, START + 12, START + 21, START + 29
# Of a reference among these: whether it is hydroacoustic, its place (3), the transponder's (3), noise.
IS_ACOUSTIC, PLACE, TRANSPONDER, NOISE, REFERENCE = 0, 1, 4, 7, 8
# Inputs: of a reference value (3), validity, time; of the compass heading, validity, time; then mru, wind, thrust.
INPUT, COMPASS_INPUT, MRU_INPUT = 5, 3, 3
# What an observer keeps of an instrument: time of its last value [s], that value (3), how often it came unchanged, and
# since when all of them are wild [s].
SEEN, VALUE, AGAIN, WILD_SINCE, RECORD = 0, 1, 4, 5, 6
# An estimate: position and heading (3), velocity in the body frame (3), slow load in the world (3), and for north, east
# and heading a wave's integral and the wave (6).
ETA, NU, BIAS, WAVE, STATES = 0, 3, 6, 9, 15
# What every observer keeps beside its estimate: the wind's load (3), when a position was used last [s], whether
# position and heading were ever given, how many attitudes it has seen, the last of them (roll, pitch and heading, each
# step, in a ring), then a record of each reference and of the compass.
LOAD, LAST_FIX, HAS_POSITION, HAS_HEADING, KNOWN, ATTITUDES = 0, 3, 4, 5, 6, 7
MEMORY, ATTITUDE = 128, 3
RECORDS = ATTITUDES + MEMORY * ATTITUDE
