/* FMI 2.0 for co-simulation and model exchange around a model. */

#include "fmi2Functions.h"
#include "model.h"

#include <stdlib.h>
#include <string.h>

typedef struct {
    Model m;
    const fmi2CallbackFunctions *callbacks;
} Instance;

static void forward(void *c, Status status, const char *text) {
    const fmi2CallbackFunctions *to = ((Instance *)c)->callbacks;
    if (to && to->logger)
        to->logger(to->componentEnvironment, ((Model *)c)->name, (fmi2Status)status, "log", "%s", text);
}

static fmi2Status of(Status status) { return (fmi2Status)status; }

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    return (void)c, (void)on, (void)n, (void)categories, fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String place,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logs) {
    (void)type, (void)place, (void)visible, (void)logs;
    Instance *one = core_may_be_made(token) ? calloc(1, sizeof *one) : NULL;
    if (!one)
        return NULL;
    one->m.log = forward;
    one->callbacks = callbacks;
    strncpy(one->m.name, name, LENGTH - 1);
    model_start(&one->m.v);
    return one;
}

void fmi2FreeInstance(fmi2Component c) {
    if (c)
        model_trouble(c, IN_FREE);
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    ((Model *)c)->v.t = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Model *m = c;
    Status status = model_trouble(m, IN_START);
    model_event(&m->v);
    model_outputs(&m->v);
    return of(status);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    model_outputs(&((Model *)c)->v);
    return of(model_trouble(c, AFTER_START));
}

fmi2Status fmi2Terminate(fmi2Component c) { return of(model_trouble(c, IN_TERMINATE)); }

fmi2Status fmi2Reset(fmi2Component c) {
    Model *m = c;
    memset(&m->v, 0, sizeof m->v);
    model_start(&m->v);
    return fmi2OK;
}

#define ACCESS(Name, Type, array, FIRST, MOST)                                                              \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2##Type value[]) { \
        Model *m = c;                                                                                       \
        Status status = model_trouble(m, IN_GET);                                                           \
        for (size_t k = 0; k < n; k++) {                                                                    \
            if (vr[k] - FIRST >= MOST)                                                                      \
                return fmi2Error;                                                                           \
            value[k] = (fmi2##Type)m->v.array[vr[k] - FIRST];                                               \
        }                                                                                                   \
        return of(status);                                                                                  \
    }

#define CHANGE(Name, array, FIRST, MOST, ...)                                                             \
    fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n,                    \
                             const fmi2##Name value[]) {                                                  \
        Model *m = c;                                                                                     \
        Status status = model_trouble(m, IN_SET);                                                         \
        for (size_t k = 0; k < n; k++) {                                                                  \
            if (vr[k] - FIRST >= MOST)                                                                    \
                return fmi2Error;                                                                         \
            __VA_ARGS__;                                                                                  \
        }                                                                                                 \
        model_outputs(&m->v);                                                                             \
        return of(status);                                                                                \
    }

ACCESS(Real, Real, r, REAL, REALS)
ACCESS(Integer, Integer, i, INTEGER, INTEGERS)
ACCESS(Boolean, Boolean, b, BOOLEAN, BOOLEANS)
ACCESS(String, String, s, TEXT, TEXTS)
CHANGE(Real, r, REAL, REALS, m->v.r[vr[k] - REAL] = value[k])
CHANGE(Integer, i, INTEGER, INTEGERS, m->v.i[vr[k] - INTEGER] = value[k])
CHANGE(Boolean, b, BOOLEAN, BOOLEANS, m->v.b[vr[k] - BOOLEAN] = value[k])
CHANGE(String, s, TEXT, TEXTS, strncpy(m->v.s[vr[k] - TEXT], value[k], LENGTH - 1))

/* The whole state is the values. */
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state)
        *state = malloc(sizeof(Values));
    memcpy(*state, &((Model *)c)->v, sizeof(Values));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    memcpy(&((Model *)c)->v, state, sizeof(Values));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    free(*state);
    *state = NULL;
    return (void)c, fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    *size = sizeof(Values);
    return (void)c, (void)state, fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    memcpy(bytes, state, size);
    return (void)c, fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    if (size != sizeof(Values))
        return fmi2Error;
    if (!*state)
        *state = malloc(size);
    memcpy(*state, bytes, size);
    return (void)c, fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real d_known[],
                                        fmi2Real d_unknown[]) {
    (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)d_known, (void)d_unknown;
    return (void)c, fmi2Error;
}

/* Model exchange. */
fmi2Status fmi2EnterEventMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return (void)c, fmi2OK; }

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    Values *v = &((Model *)c)->v;
    memset(info, 0, sizeof *info);
    info->valuesOfContinuousStatesChanged = model_event(v);
    info->terminateSimulation = v->terminate;
    info->nextEventTimeDefined = v->next < HUGE_VAL;
    info->nextEventTime = v->next;
    model_outputs(v);
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set, fmi2Boolean *enter, fmi2Boolean *stop) {
    *enter = *stop = fmi2False;
    return (void)no_set, of(model_trouble(c, IN_STEP));
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    ((Model *)c)->v.t = t;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    memcpy(((Model *)c)->v.r, x, n * sizeof *x);
    model_outputs(&((Model *)c)->v);
    return n == N_STATES ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    model_derivatives(&((Model *)c)->v, dx);
    return n == N_STATES ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    model_indicators(&((Model *)c)->v, z);
    return n == N_INDICATORS ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    memcpy(x, ((Model *)c)->v.r, n * sizeof *x);
    return n == N_STATES ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n) {
    for (size_t k = 0; k < n; k++)
        nominals[k] = 1.0;
    return (void)c, fmi2OK;
}

/* Co-simulation. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    return (void)c, (void)vr, (void)n, (void)order, (void)value, fmi2Error;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    return (void)c, (void)vr, (void)n, (void)order, (void)value, fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set) {
    int event;
    (void)no_set;
    Status status = core_step(c, t, h, &event);
    return status == OK && ((Model *)c)->v.terminate ? fmi2Discard : of(status);
}

fmi2Status fmi2CancelStep(fmi2Component c) { return (void)c, fmi2Error; }

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    Values *v = &((Model *)c)->v;
    *value = v->terminate ? v->t : v->reached;
    return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    *value = ((Model *)c)->v.terminate;
    return kind == fmi2Terminated ? fmi2OK : fmi2Discard;
}

#define NOT_TOLD(Name, Type)                                                                     \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2StatusKind kind, Type *value) { \
        return (void)c, (void)kind, (void)value, fmi2Discard;                                    \
    }

NOT_TOLD(Status, fmi2Status)
NOT_TOLD(IntegerStatus, fmi2Integer)
NOT_TOLD(StringStatus, fmi2String)
