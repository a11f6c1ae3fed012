/* The functions of FMI 2.0 for co-simulation, after chapters 2 and 4 of the standard. */

#include "core.h"

#include <string.h>

#define EXPORT __attribute__((visibility("default")))

typedef int Boolean;
typedef enum { MODEL_EXCHANGE, CO_SIMULATION } Kind;
typedef enum { DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED_STATUS } StatusKind;
typedef void Logger(void *environment, const char *instance, Status, const char *category, const char *message, ...);

typedef struct {
    Logger *logger;
    void *(*allocate)(size_t n, size_t size);
    void (*release)(void *);
    void (*step_finished)(void *environment, Status);
    void *environment;
} Callbacks;

/* The message is the format of a printf: its % are doubled. */
static void log_message(Instance *instance, Status status, const char *message) {
    char format[2048];
    size_t k = 0;
    for (; *message && k < sizeof format - 2; message++) {
        if (*message == '%')
            format[k++] = '%';
        format[k++] = *message;
    }
    format[k] = '\0';
    Logger *logger = (Logger *)instance->callback;
    if (logger)
        logger(instance->environment, instance->name, status, LOG_CATEGORY, format);
}

EXPORT const char *fmi2GetTypesPlatform(void) {
    return "default";
}

EXPORT const char *fmi2GetVersion(void) {
    return "2.0";
}

/* Only errors are logged, and those always. */
EXPORT Status fmi2SetDebugLogging(Instance *c, Boolean on, size_t n, const char *const categories[]) {
    return c ? OK : ERROR;
}

EXPORT Instance *fmi2Instantiate(const char *name, Kind kind, const char *guid, const char *resources,
                                 const Callbacks *callbacks, Boolean visible, Boolean logging_on) {
    Instance *instance = instance_new(name);
    if (!instance)
        return NULL;
    instance->log = log_message;
    if (callbacks) {
        instance->callback = (void (*)(void))callbacks->logger;
        instance->environment = callbacks->environment;
    }
    if (kind == CO_SIMULATION && guid && strcmp(guid, MODEL_TOKEN) == 0)
        return instance;
    if (kind != CO_SIMULATION)
        report(instance, ERROR, "%s is for co-simulation only", MODEL_NAME);
    else
        report(instance, ERROR, "the guid is '%s', but that of this binary is '%s'", guid ? guid : "", MODEL_TOKEN);
    instance_free(instance);
    return NULL;
}

EXPORT void fmi2FreeInstance(Instance *c) {
    instance_free(c);
}

/* The tolerance is not heeded: the component's own parameters say how accurate it is. */
EXPORT Status fmi2SetupExperiment(Instance *c, Boolean has_tolerance, double tolerance, double start, Boolean has_stop,
                                  double stop) {
    return c ? initialization_plan(c, start, has_stop, stop) : ERROR;
}

EXPORT Status fmi2EnterInitializationMode(Instance *c) {
    return c ? initialization_begin(c) : ERROR;
}

EXPORT Status fmi2ExitInitializationMode(Instance *c) {
    return c ? initialization_end(c) : ERROR;
}

EXPORT Status fmi2Terminate(Instance *c) {
    return c ? terminate(c) : ERROR;
}

EXPORT Status fmi2Reset(Instance *c) {
    if (!c)
        return ERROR;
    instance_reset(c);
    return OK;
}

EXPORT Status fmi2GetReal(Instance *c, const uint32_t references[], size_t n, double values[]) {
    return c ? get_reals(c, references, n, values, n) : ERROR;
}

EXPORT Status fmi2SetReal(Instance *c, const uint32_t references[], size_t n, const double values[]) {
    return c ? set_reals(c, references, n, values, n) : ERROR;
}

EXPORT Status fmi2GetInteger(Instance *c, const uint32_t references[], size_t n, int values[]) {
    if (!c || is_given(c, references, n, values, "get") != OK)
        return ERROR;
    for (size_t i = 0; i < n; i++) {
        const Variable *at = constant(c, references[i], INTEGER, "Integer");
        if (!at)
            return ERROR;
        values[i] = (int)MODEL_INTEGERS[at->first];
    }
    return OK;
}

EXPORT Status fmi2GetBoolean(Instance *c, const uint32_t references[], size_t n, Boolean values[]) {
    if (!c || is_given(c, references, n, values, "get") != OK)
        return ERROR;
    for (size_t i = 0; i < n; i++) {
        const Variable *at = constant(c, references[i], BOOLEAN, "Boolean");
        if (!at)
            return ERROR;
        values[i] = MODEL_BOOLEANS[at->first];
    }
    return OK;
}

EXPORT Status fmi2GetString(Instance *c, const uint32_t references[], size_t n, const char *values[]) {
    if (!c || is_given(c, references, n, values, "get") != OK)
        return ERROR;
    for (size_t i = 0; i < n; i++) {
        const Variable *at = constant(c, references[i], TEXT, "String");
        if (!at)
            return ERROR;
        values[i] = MODEL_TEXTS[at->first];
    }
    return OK;
}

/* What asks for nothing (n = 0) is granted. */
static Status refuse(Instance *c, size_t n, const char *why) {
    if (!c)
        return ERROR;
    return n == 0 ? OK : report(c, ERROR, "%s", why);
}

EXPORT Status fmi2SetInteger(Instance *c, const uint32_t references[], size_t n, const int values[]) {
    return refuse(c, n, "integers were fixed when the FMU was built");
}

EXPORT Status fmi2SetBoolean(Instance *c, const uint32_t references[], size_t n, const Boolean values[]) {
    return refuse(c, n, "booleans were fixed when the FMU was built");
}

EXPORT Status fmi2SetString(Instance *c, const uint32_t references[], size_t n, const char *const values[]) {
    return refuse(c, n, "strings were fixed when the FMU was built");
}

EXPORT Status fmi2GetFMUstate(Instance *c, State **state) {
    return c ? state_get(c, state) : ERROR;
}

EXPORT Status fmi2SetFMUstate(Instance *c, State *state) {
    return c ? state_restore(c, state) : ERROR;
}

EXPORT Status fmi2FreeFMUstate(Instance *c, State **state) {
    return c ? state_free(state) : ERROR;
}

EXPORT Status fmi2SerializedFMUstateSize(Instance *c, State *state, size_t *size) {
    return c ? state_size(size) : ERROR;
}

EXPORT Status fmi2SerializeFMUstate(Instance *c, State *state, char bytes[], size_t size) {
    return c ? state_write(c, state, bytes, size) : ERROR;
}

EXPORT Status fmi2DeSerializeFMUstate(Instance *c, const char bytes[], size_t size, State **state) {
    return c ? state_read(c, bytes, size, state) : ERROR;
}

EXPORT Status fmi2GetDirectionalDerivative(Instance *c, const uint32_t unknowns[], size_t n_unknowns,
                                           const uint32_t knowns[], size_t n_knowns, const double seed[],
                                           double sensitivity[]) {
    return refuse(c, n_unknowns, "no directional derivatives are provided");
}

EXPORT Status fmi2SetRealInputDerivatives(Instance *c, const uint32_t references[], size_t n, const int order[],
                                          const double values[]) {
    return refuse(c, n, "inputs are not interpolated");
}

EXPORT Status fmi2GetRealOutputDerivatives(Instance *c, const uint32_t references[], size_t n, const int order[],
                                           double values[]) {
    return refuse(c, n, "no derivatives of outputs are provided");
}

EXPORT Status fmi2DoStep(Instance *c, double t, double h, Boolean no_going_back) {
    return c ? step_to(c, t, h) : ERROR;
}

EXPORT Status fmi2CancelStep(Instance *c) {
    return refuse(c, 1, "no step is under way: steps are made at once");
}

EXPORT Status fmi2GetStatus(Instance *c, StatusKind kind, Status *value) {
    if (!c || !value || kind != DO_STEP_STATUS)
        return refuse(c, 1, "this status is not provided");
    *value = c->state->phase == FAILED ? ERROR : OK;
    return OK;
}

EXPORT Status fmi2GetRealStatus(Instance *c, StatusKind kind, double *value) {
    if (!c || !value || kind != LAST_SUCCESSFUL_TIME)
        return refuse(c, 1, "this status is not provided");
    *value = seconds(c);
    return OK;
}

EXPORT Status fmi2GetIntegerStatus(Instance *c, StatusKind kind, int *value) {
    return refuse(c, 1, "this status is not provided");
}

EXPORT Status fmi2GetBooleanStatus(Instance *c, StatusKind kind, Boolean *value) {
    if (!c || !value || kind != TERMINATED_STATUS)
        return refuse(c, 1, "this status is not provided");
    *value = 0;
    return OK;
}

EXPORT Status fmi2GetStringStatus(Instance *c, StatusKind kind, const char **value) {
    return refuse(c, 1, "this status is not provided");
}
