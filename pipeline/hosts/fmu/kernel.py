"""The step of a co-simulation FMU, compiled: sets inputs, calls doStep and gets outputs through C pointers.

It has the contract's signature. w is the address of the host's table (see table.py), so that the conductor's loop
calls an FMU as it calls any component.
"""

# An intrinsic is called without the typing context that its definition begins with.
# pyright: reportCallIssue=false

import numpy as np
from numba import cfunc, njit
from numba.np.numpy_support import carray

from components.compiled import OPTIONS, SIGNATURE
from components.contract import HEADER
from pipeline.hosts.fmu.c_access import (
    address_of_element,
    as_words,
    ask,
    do_step,
    do_step_3,
    exchange,
    exchange_3,
    load_double,
    load_float,
    load_int8,
    load_int16,
    load_int32,
    load_uint8,
    load_uint16,
    load_uint32,
    store_double,
    store_float,
    store_int8,
    store_int16,
    store_int32,
    store_int64,
    store_uint8,
    store_uint16,
    store_uint32,
    store_uint64,
    word,
)
from pipeline.hosts.fmu.kinds import (
    BOOL8,
    BOOL32,
    EXACT,
    FLOAT32,
    FLOAT64,
    HIGH,
    INT8,
    INT16,
    INT32,
    INT64,
    LOW,
    UINT8,
    UINT16,
    UINT32,
    UINT64,
)
from pipeline.hosts.fmu.table import (
    ASK,
    BEFORE,
    CALLS_MADE,
    CODE,
    COLUMNS,
    CONVERTS,
    DO_STEP,
    ELEMENT,
    FACTORS,
    FINISH_STEP,
    FIRST,
    FLAGS,
    FUNCTION,
    HAS_EVENTS,
    HEAD,
    INSTANCE,
    IS_DISCRETE,
    LAST,
    MEET_EVENT,
    N_GET,
    N_REFERENCES,
    N_SET,
    N_TUNABLE,
    N_VALUES,
    NOT_EXACT,
    NOT_WHOLE,
    OFFSETS,
    OK_OR_WARNING,
    PLACES,
    REFERENCES,
    REFUSED,
    RETURNED,
    TUNE,
    TUNED,
    VALUES,
    VERSION,
    WHERE,
)

NS = 1e9
WHOLE = int(EXACT)


@njit(**OPTIONS)
def put(code, address, i, value):
    """Store a number as element i of an array of the FMU's type; whether it could be."""
    if code == FLOAT64:
        store_double(address, i, value)
        return True
    if code == FLOAT32:
        if not (LOW[code] <= value <= HIGH[code]):
            return False
        store_float(address, i, value)
        return True
    if not (value == np.floor(value) and LOW[code] <= value <= HIGH[code]):
        return False
    if code in (INT32, BOOL32):
        store_int32(address, i, value)
    elif code in (UINT8, BOOL8):
        store_uint8(address, i, value)
    elif code == INT64:
        store_int64(address, i, value)
    elif code == UINT64:
        store_uint64(address, i, value)
    elif code == UINT32:
        store_uint32(address, i, value)
    elif code == INT16:
        store_int16(address, i, value)
    elif code == UINT16:
        store_uint16(address, i, value)
    elif code == INT8:
        store_int8(address, i, value)
    return True


@njit(**OPTIONS)
def take(code, address, i):
    """Element i of an array of the FMU's type; (number, whether float64 holds it exactly)."""
    value, is_exact = 0.0, True
    if code == FLOAT64:
        value = load_double(address, i)
    elif code == FLOAT32:
        value = load_float(address, i)
    elif code == BOOL32:
        value = 1.0 if load_int32(address, i) != 0.0 else 0.0
    elif code == BOOL8:
        value = 1.0 if load_uint8(address, i) != 0.0 else 0.0
    elif code in (INT64, UINT64):
        whole = word(address, i)
        value = float(whole)
        is_exact = (0 if code == UINT64 else -WHOLE) <= whole <= WHOLE
    elif code == INT32:
        value = load_int32(address, i)
    elif code == UINT32:
        value = load_uint32(address, i)
    elif code == INT16:
        value = load_int16(address, i)
    elif code == UINT16:
        value = load_uint16(address, i)
    elif code == INT8:
        value = load_int8(address, i)
    elif code == UINT8:
        value = load_uint8(address, i)
    return value, is_exact


@njit(**OPTIONS)
def transfer(k, e, values):
    """Call an exchange's function; its status."""
    if k[VERSION] == 3:
        return exchange_3(k[e + FUNCTION], k[INSTANCE], k[e + REFERENCES], k[e + N_REFERENCES], values, k[e + N_VALUES])
    return exchange(k[e + FUNCTION], k[INSTANCE], k[e + REFERENCES], k[e + N_REFERENCES], values)


@njit(**OPTIONS)
def fill(k, e, u):
    """Write an exchange's values from u; the first that cannot be, or -1."""
    for i in range(k[e + N_VALUES]):
        value = u[word(k[e + PLACES], i)]
        if k[e + CONVERTS]:
            value = (value - load_double(k[e + OFFSETS], i)) / load_double(k[e + FACTORS], i)
        if not put(k[e + CODE], k[e + VALUES], i, value):
            return i
    return -1


@njit(**OPTIONS)
def differs(k, e, u):
    """Whether an exchange's inputs are others than were set last; they are noted."""
    found = False
    for i in range(k[e + N_VALUES]):
        value = u[word(k[e + PLACES], i)]
        if value != load_double(k[e + BEFORE], i):
            store_double(k[e + BEFORE], i, value)
            found = True
    return found


@njit(**OPTIONS)
def set_inputs(k, u, t_ns, dt_ns):
    """Set all inputs; those that change at events only by way of the host, where the FMU has an event mode."""
    meets_event = False
    for j in range(k[N_SET]):
        e = HEAD + j * COLUMNS
        k[WHERE] = j
        waits = k[HAS_EVENTS] != 0 and k[e + IS_DISCRETE] != 0
        if waits and not differs(k, e, u):
            continue
        values = k[e + VALUES]
        if k[e + FIRST] >= 0:
            values = address_of_element(u, k[e + FIRST])
        else:
            bad = fill(k, e, u)
            if bad >= 0:
                k[ELEMENT] = bad
                return NOT_WHOLE
        if waits:
            meets_event = True
            continue
        k[RETURNED] = transfer(k, e, values)
        if k[RETURNED] > OK_OR_WARNING:
            return REFUSED
    return ask(k[ASK], t_ns, dt_ns, MEET_EVENT) if meets_event else 0


@njit(**OPTIONS)
def get_outputs(k, y):
    """Get all outputs."""
    for j in range(k[N_SET], k[N_SET] + k[N_GET]):
        e = HEAD + j * COLUMNS
        is_direct = k[e + FIRST] >= 0
        k[WHERE] = j
        values = address_of_element(y, k[e + FIRST]) if is_direct else k[e + VALUES]
        k[RETURNED] = transfer(k, e, values)
        if k[RETURNED] > OK_OR_WARNING:
            return REFUSED
        if is_direct:
            continue
        for i in range(k[e + N_VALUES]):
            value, is_exact = take(k[e + CODE], k[e + VALUES], i)
            if not is_exact:
                k[ELEMENT] = i
                return NOT_EXACT
            if k[e + CONVERTS]:
                value = value * load_double(k[e + FACTORS], i) + load_double(k[e + OFFSETS], i)
            y[word(k[e + PLACES], i)] = value
    return 0


@njit(**OPTIONS)
def advance(k, t_ns, dt_ns):
    """Call doStep; what is not a plain success is left to the host."""
    t, h = (t_ns - dt_ns) / NS, dt_ns / NS
    if k[VERSION] < 3:
        k[RETURNED] = do_step(k[DO_STEP], k[INSTANCE], t, h, np.int32(1))
        is_done = True
    else:
        flags = k[FLAGS]
        k[RETURNED] = do_step_3(k[DO_STEP], k[INSTANCE], t, h, np.int32(1), flags, flags + 1, flags + 2, k[LAST])
        is_done = load_uint8(flags, 0) + load_uint8(flags, 1) + load_uint8(flags, 2) == 0.0
    if k[RETURNED] <= OK_OR_WARNING and is_done:
        return 0
    return ask(k[ASK], t_ns, dt_ns, FINISH_STEP)


@njit(**OPTIONS)
def is_tuned(k, p):
    """Whether the FMU has the tunable parameters of p."""
    others = 0
    for i in range(k[N_TUNABLE]):
        if p[HEADER + i] != load_double(k[TUNED], i):
            others += 1
    return others == 0


@njit(**OPTIONS)
def step(t_ns, dt_ns, p, u, y, k):
    """One communication step; a status."""
    status = 0
    k[CALLS_MADE] += 1
    if not is_tuned(k, p):
        status = ask(k[ASK], t_ns, dt_ns, TUNE)
    if status == 0:
        status = set_inputs(k, u, t_ns, dt_ns)
    if status == 0:
        status = advance(k, t_ns, dt_ns)
    if status == 0:
        status = get_outputs(k, y)
    k[CALLS_MADE] += 1
    return status


@cfunc(SIGNATURE, cache=True, error_model="numpy")
def fmu_step(t_ns, dt_ns, p, u, x, y, w):
    """The contract's function."""
    head = carray(as_words(w), HEAD)
    k = carray(as_words(w), HEAD + (head[N_SET] + head[N_GET]) * COLUMNS)
    n = carray(p, HEADER)
    return step(t_ns, dt_ns, carray(p, int(n[0])), carray(u, int(n[1])), carray(y, int(n[3])), k)


@cfunc(SIGNATURE, cache=True, error_model="numpy")
def fmu_inputs(t_ns, dt_ns, p, u, x, y, w):
    """Set the inputs alone, as before a step."""
    head = carray(as_words(w), HEAD)
    k = carray(as_words(w), HEAD + (head[N_SET] + head[N_GET]) * COLUMNS)
    return set_inputs(k, carray(u, int(carray(p, HEADER)[1])), t_ns, dt_ns)


@cfunc(SIGNATURE, cache=True, error_model="numpy")
def fmu_outputs(t_ns, dt_ns, p, u, x, y, w):
    """Get the outputs alone, as after a step."""
    head = carray(as_words(w), HEAD)
    k = carray(as_words(w), HEAD + (head[N_SET] + head[N_GET]) * COLUMNS)
    return get_outputs(k, carray(y, int(carray(p, HEADER)[3])))
