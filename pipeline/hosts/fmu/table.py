"""What the compiled step reads about one FMU instance: a table of words, and the columns' names."""

from __future__ import annotations

# Words of the table's head. Addresses are machine addresses.
(
    VERSION,  # of FMI: 1, 2 or 3
    INSTANCE,
    DO_STEP,
    ASK,  # the host's own function, for what is rare
    N_SET,
    N_GET,
    N_TUNABLE,
    TUNED,  # float64: tunable parameters as the FMU has them
    HAS_EVENTS,  # whether discrete inputs are set in event mode only
    FLAGS,  # 3 bytes of FMI 3: event needed, terminate, early return
    LAST,  # float64: last successful time
    WHERE,  # the exchange that failed
    ELEMENT,  # its value that cannot be passed on
    RETURNED,  # what the FMU's function returned
    CALLS_MADE,  # counts up as a step begins and as it ends: odd within one
    HEAD,
) = range(16)
# Words of an exchange: one call of a Set or Get function. Those that set come first.
(
    FUNCTION,
    REFERENCES,
    N_REFERENCES,
    N_VALUES,
    VALUES,  # in the FMU's type
    CODE,  # of the type, see kinds
    PLACES,  # int64: where in u or y each value is
    FIRST,  # that of the first, where float64s stand together and need no conversion; else -1
    CONVERTS,
    FACTORS,
    OFFSETS,
    IS_DISCRETE,
    BEFORE,  # float64: what was set last
    COLUMNS,
) = range(14)

# What ASK is asked.
TUNE, MEET_EVENT, FINISH_STEP = range(3)
# Statuses of the compiled step, beside hosts.python.RAISED.
NOT_WHOLE, NOT_EXACT, REFUSED = -11, -12, -13
OK_OR_WARNING = 1
