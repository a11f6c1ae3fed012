/* FMI 3.0 for co-simulation, with event mode and early return, and model exchange, around a model. */

#include "fmi3Functions.h"
#include "model.h"

#include <stdlib.h>
#include <string.h>

typedef struct {
    Model m;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback logger;
} Instance;

static void forward(void *c, Status status, const char *text) {
    Instance *one = c;
    if (one->logger)
        one->logger(one->environment, (fmi3Status)status, "log", text);
}

static fmi3Status of(Status status) { return (fmi3Status)status; }

static Instance *made(fmi3String name, fmi3String token, fmi3InstanceEnvironment environment,
                      fmi3LogMessageCallback logger) {
    Instance *one = core_may_be_made(token) ? calloc(1, sizeof *one) : NULL;
    if (!one)
        return NULL;
    one->m.log = forward;
    one->environment = environment;
    one->logger = logger;
    strncpy(one->m.name, name, LENGTH - 1);
    model_start(&one->m.v);
    return one;
}

const char *fmi3GetVersion(void) { return "3.0"; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    return (void)c, (void)on, (void)n, (void)categories, fmi3OK;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible,
                                          fmi3Boolean logs, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
    (void)place, (void)visible, (void)logs;
    return made(name, token, environment, logger);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible,
                                         fmi3Boolean logs, fmi3Boolean has_events, fmi3Boolean returns_early,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    (void)place, (void)visible, (void)logs, (void)required, (void)n_required, (void)update;
    Instance *one = made(name, token, environment, logger);
    if (one)
        one->m.v.stops_at_events = has_events && returns_early;
    return one;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String place,
                                               fmi3Boolean visible, fmi3Boolean logs,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)place, (void)visible, (void)logs, (void)environment, (void)logger, (void)update;
    return (void)lock, (void)unlock, NULL;
}

void fmi3FreeInstance(fmi3Instance c) {
    if (c)
        model_trouble(c, IN_FREE);
    free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    Model *m = c;
    m->v.t = start;
    Status status = model_trouble(m, IN_START);
    if (!m->v.stops_at_events)
        model_event(&m->v);
    model_outputs(&m->v);
    return of(status);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    model_outputs(&((Model *)c)->v);
    return of(model_trouble(c, AFTER_START));
}

fmi3Status fmi3EnterEventMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return of(model_trouble(c, IN_TERMINATE)); }

fmi3Status fmi3Reset(fmi3Instance c) {
    Model *m = c;
    int stops = m->v.stops_at_events;
    memset(&m->v, 0, sizeof m->v);
    m->v.stops_at_events = stops;
    model_start(&m->v);
    return fmi3OK;
}

/* Values of scalars and arrays in turn; n_values must be theirs. */
#define ACCESS(Name, Type, array, FIRST, MOST)                                                                \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, Type value[], size_t n_values) { \
        Model *m = c;                                                                                         \
        size_t filled = 0;                                                                                    \
        m->v.r[TIME] = m->v.t;                                                                                \
        Status status = model_trouble(m, IN_GET);                                                             \
        for (size_t k = 0; k < n; k++) {                                                                      \
            size_t size = model_size(&m->v, vr[k]);                                                           \
            if (vr[k] - FIRST + size > MOST || filled + size > n_values)                                      \
                return fmi3Error;                                                                             \
            for (size_t j = 0; j < size; j++)                                                                 \
                value[filled++] = (Type)m->v.array[vr[k] - FIRST + j];                                        \
        }                                                                                                     \
        return filled == n_values ? of(status) : fmi3Error;                                                   \
    }

#define CHANGE(Name, Type, FIRST, MOST, ...)                                                                  \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const Type value[],     \
                             size_t n_values) {                                                               \
        Model *m = c;                                                                                         \
        size_t taken = 0;                                                                                     \
        Status status = model_trouble(m, IN_SET);                                                             \
        for (size_t k = 0; k < n; k++) {                                                                      \
            size_t size = model_size(&m->v, vr[k]);                                                           \
            if (vr[k] - FIRST + size > MOST || taken + size > n_values)                                       \
                return fmi3Error;                                                                             \
            for (size_t j = 0; j < size; j++, taken++) {                                                      \
                size_t at = vr[k] - FIRST + j;                                                                \
                __VA_ARGS__;                                                                                  \
            }                                                                                                 \
        }                                                                                                     \
        model_outputs(&m->v);                                                                                 \
        return taken == n_values ? of(status) : fmi3Error;                                                    \
    }

#define NUMBER(Name, Type, array, FIRST, MOST) \
    ACCESS(Name, Type, array, FIRST, MOST)     \
    CHANGE(Name, Type, FIRST, MOST, m->v.array[at] = value[taken])

NUMBER(Float32, fmi3Float32, r, REAL, REALS)
NUMBER(Float64, fmi3Float64, r, REAL, REALS)
NUMBER(Int8, fmi3Int8, i, INTEGER, INTEGERS)
NUMBER(UInt8, fmi3UInt8, i, INTEGER, INTEGERS)
NUMBER(Int16, fmi3Int16, i, INTEGER, INTEGERS)
NUMBER(UInt16, fmi3UInt16, i, INTEGER, INTEGERS)
NUMBER(Int32, fmi3Int32, i, INTEGER, INTEGERS)
NUMBER(UInt32, fmi3UInt32, i, INTEGER, INTEGERS)
NUMBER(Int64, fmi3Int64, i, INTEGER, INTEGERS)
NUMBER(UInt64, fmi3UInt64, i, INTEGER, INTEGERS)
NUMBER(Boolean, fmi3Boolean, b, BOOLEAN, BOOLEANS)
ACCESS(String, fmi3String, s, TEXT, TEXTS)
CHANGE(String, fmi3String, TEXT, TEXTS, strncpy(m->v.s[at], value[taken], LENGTH - 1))

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary values[],
                         size_t n_values) {
    Values *v = &((Model *)c)->v;
    for (size_t k = 0; k < n; k++) {
        if (vr[k] - BINARY >= BINARIES)
            return fmi3Error;
        sizes[k] = v->n_bytes[vr[k] - BINARY];
        values[k] = v->bytes[vr[k] - BINARY];
    }
    return n == n_values ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                         const fmi3Binary values[], size_t n_values) {
    Values *v = &((Model *)c)->v;
    for (size_t k = 0; k < n; k++) {
        if (vr[k] - BINARY >= BINARIES || sizes[k] > LENGTH)
            return fmi3Error;
        v->n_bytes[vr[k] - BINARY] = sizes[k];
        memcpy(v->bytes[vr[k] - BINARY], values[k], sizes[k]);
    }
    model_outputs(v);
    return n == n_values ? fmi3OK : fmi3Error;
}

/* The whole state is the values. */
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    if (!*state)
        *state = malloc(sizeof(Values));
    memcpy(*state, &((Model *)c)->v, sizeof(Values));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    memcpy(&((Model *)c)->v, state, sizeof(Values));
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    free(*state);
    *state = NULL;
    return (void)c, fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    *size = sizeof(Values);
    return (void)c, (void)state, fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    memcpy(bytes, state, size);
    return (void)c, fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    if (size != sizeof(Values))
        return fmi3Error;
    if (!*state)
        *state = malloc(size);
    memcpy(*state, bytes, size);
    return (void)c, fmi3OK;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return (void)c, fmi3OK; }

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    model_outputs(&((Model *)c)->v);
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) { return (void)c, fmi3OK; }

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *stop, fmi3Boolean *nominals,
                                    fmi3Boolean *states, fmi3Boolean *has_next, fmi3Float64 *next) {
    Values *v = &((Model *)c)->v;
    *again = *nominals = fmi3False;
    *states = model_event(v);
    *stop = v->terminate;
    *has_next = v->next < HUGE_VAL;
    *next = v->next;
    model_outputs(v);
    return fmi3OK;
}

/* Model exchange. */
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return (void)c, fmi3OK; }

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_set, fmi3Boolean *enter, fmi3Boolean *stop) {
    *enter = *stop = fmi3False;
    return (void)no_set, of(model_trouble(c, IN_STEP));
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t) {
    ((Model *)c)->v.t = t;
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) {
    memcpy(((Model *)c)->v.r, x, n * sizeof *x);
    model_outputs(&((Model *)c)->v);
    return n == N_STATES ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 dx[], size_t n) {
    model_derivatives(&((Model *)c)->v, dx);
    return n == N_STATES ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n) {
    model_indicators(&((Model *)c)->v, z);
    return n == N_INDICATORS ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) {
    memcpy(x, ((Model *)c)->v.r, n * sizeof *x);
    return n == N_STATES ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[], size_t n) {
    for (size_t k = 0; k < n; k++)
        nominals[k] = 1.0;
    return (void)c, fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) {
    *n = N_INDICATORS;
    return (void)c, fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) {
    *n = N_STATES;
    return (void)c, fmi3OK;
}

/* Co-simulation. */
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return (void)c, fmi3OK; }

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *stop, fmi3Boolean *early, fmi3Float64 *reached) {
    Model *m = c;
    int stopped = 0;
    (void)no_set;
    Status status = core_step(m, t, h, &stopped);
    *event = stopped;
    *early = m->v.t < t + h - 1e-12;
    *stop = m->v.terminate;
    *reached = status == DISCARD ? m->v.reached : m->v.t;
#ifdef REACHED
    *reached = REACHED;
#endif
    return of(status);
}

/* What no model here has. */
#define REFUSED(name, ...) \
    fmi3Status name(fmi3Instance c, __VA_ARGS__) { return (void)c, fmi3Error; }

#define REFERENCES const fmi3ValueReference vr[], size_t n

#pragma GCC diagnostic ignored "-Wunused-parameter"
REFUSED(fmi3GetClock, REFERENCES, fmi3Clock values[])
REFUSED(fmi3SetClock, REFERENCES, const fmi3Clock values[])
REFUSED(fmi3GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t *n)
REFUSED(fmi3GetVariableDependencies, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independent[],
        size_t independents[], fmi3DependencyKind kinds[], size_t n)
REFUSED(fmi3GetDirectionalDerivative, REFERENCES, const fmi3ValueReference knowns[], size_t n_knowns,
        const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity)
REFUSED(fmi3GetAdjointDerivative, REFERENCES, const fmi3ValueReference knowns[], size_t n_knowns,
        const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity)
REFUSED(fmi3GetIntervalDecimal, REFERENCES, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
REFUSED(fmi3GetIntervalFraction, REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
        fmi3IntervalQualifier qualifiers[])
REFUSED(fmi3GetShiftDecimal, REFERENCES, fmi3Float64 shifts[])
REFUSED(fmi3GetShiftFraction, REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
REFUSED(fmi3SetIntervalDecimal, REFERENCES, const fmi3Float64 intervals[])
REFUSED(fmi3SetIntervalFraction, REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSED(fmi3SetShiftDecimal, REFERENCES, const fmi3Float64 shifts[])
REFUSED(fmi3SetShiftFraction, REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSED(fmi3GetOutputDerivatives, REFERENCES, const fmi3Int32 orders[], fmi3Float64 values[], size_t n_values)
REFUSED(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 t)
