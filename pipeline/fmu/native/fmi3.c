/* The functions of FMI 3.0 for co-simulation, after chapters 2 and 4 of the standard. */

#include "core.h"

#include <stdbool.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

typedef void LogMessage(void *environment, Status, const char *category, const char *message);
typedef void Callback(void);
typedef const uint32_t References[];

static void log_message(Instance *instance, Status status, const char *message) {
    LogMessage *logger = (LogMessage *)instance->callback;
    if (logger)
        logger(instance->environment, status, LOG_CATEGORY, message);
}

EXPORT const char *fmi3GetVersion(void) {
    return "3.0";
}

/* Only errors are logged, and those always. */
EXPORT Status fmi3SetDebugLogging(Instance *c, bool on, size_t n, const char *const categories[]) {
    return c ? OK : ERROR;
}

EXPORT Instance *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                             bool logging_on, bool event_mode_used, bool early_return_allowed,
                                             References required, size_t n_required, void *environment,
                                             LogMessage *logger, Callback *intermediate_update) {
    Instance *instance = instance_new(name);
    if (!instance)
        return NULL;
    instance->log = log_message;
    instance->callback = (Callback *)logger;
    instance->environment = environment;
    if (!token || strcmp(token, MODEL_TOKEN) != 0)
        report(instance, ERROR, "the token is '%s', but that of this binary is '%s'", token ? token : "", MODEL_TOKEN);
    else if (event_mode_used)
        report(instance, ERROR, "%s has no event mode", MODEL_NAME);
    else if (n_required > 0)
        report(instance, ERROR, "%s provides no intermediate update", MODEL_NAME);
    else
        return instance;
    instance_free(instance);
    return NULL;
}

EXPORT void fmi3FreeInstance(Instance *c) {
    instance_free(c);
}

/* The tolerance is not heeded: the component's own parameters say how accurate it is. */
EXPORT Status fmi3EnterInitializationMode(Instance *c, bool has_tolerance, double tolerance, double start,
                                          bool has_stop, double stop) {
    return c && initialization_plan(c, start, has_stop, stop) == OK ? initialization_begin(c) : ERROR;
}

EXPORT Status fmi3ExitInitializationMode(Instance *c) {
    return c ? initialization_end(c) : ERROR;
}

EXPORT Status fmi3Terminate(Instance *c) {
    return c ? terminate(c) : ERROR;
}

EXPORT Status fmi3Reset(Instance *c) {
    if (!c)
        return ERROR;
    instance_reset(c);
    return OK;
}

EXPORT Status fmi3GetFloat64(Instance *c, References references, size_t n, double values[], size_t n_values) {
    return c ? get_reals(c, references, n, values, n_values) : ERROR;
}

EXPORT Status fmi3SetFloat64(Instance *c, References references, size_t n, const double values[], size_t n_values) {
    return c ? set_reals(c, references, n, values, n_values) : ERROR;
}

/* Types of which there are constants only, each one value. */
#define CONSTANTS(Type, ctype, block, table)                                                                           \
    EXPORT Status fmi3Get##Type(Instance *c, References references, size_t n, ctype values[], size_t n_values) {       \
        if (!c || is_given(c, references, n, values, "get") != OK)                                                     \
            return ERROR;                                                                                              \
        if (n != n_values)                                                                                             \
            return report(c, ERROR, "%zu values asked for of %zu scalars", n_values, n);                               \
        for (size_t i = 0; i < n; i++) {                                                                               \
            const Variable *at = constant(c, references[i], block, #Type);                                             \
            if (!at)                                                                                                   \
                return ERROR;                                                                                          \
            values[i] = table[at->first];                                                                              \
        }                                                                                                              \
        return OK;                                                                                                     \
    }                                                                                                                  \
    EXPORT Status fmi3Set##Type(Instance *c, References references, size_t n, ctype const values[], size_t n_values) { \
        if (!c || n > 0)                                                                                               \
            return c ? report(c, ERROR, "variables of type " #Type " were fixed when the FMU was built") : ERROR;      \
        return OK;                                                                                                     \
    }

CONSTANTS(Int64, int64_t, INTEGER, MODEL_INTEGERS)
CONSTANTS(Boolean, bool, BOOLEAN, MODEL_BOOLEANS)
CONSTANTS(String, const char *, TEXT, MODEL_TEXTS)

EXPORT Status fmi3GetFMUState(Instance *c, State **state) {
    return c ? state_get(c, state) : ERROR;
}

EXPORT Status fmi3SetFMUState(Instance *c, State *state) {
    return c ? state_restore(c, state) : ERROR;
}

EXPORT Status fmi3FreeFMUState(Instance *c, State **state) {
    return c ? state_free(state) : ERROR;
}

EXPORT Status fmi3SerializedFMUStateSize(Instance *c, State *state, size_t *size) {
    return c ? state_size(size) : ERROR;
}

EXPORT Status fmi3SerializeFMUState(Instance *c, State *state, uint8_t bytes[], size_t size) {
    return c ? state_write(c, state, (char *)bytes, size) : ERROR;
}

EXPORT Status fmi3DeserializeFMUState(Instance *c, const uint8_t bytes[], size_t size, State **state) {
    return c ? state_read(c, (const char *)bytes, size, state) : ERROR;
}

EXPORT Status fmi3DoStep(Instance *c, double t, double h, bool no_going_back, bool *needs_event, bool *end,
                         bool *returned_early, double *last_time) {
    if (!c)
        return ERROR;
    Status status = step_to(c, t, h);
    if (needs_event)
        *needs_event = false;
    if (end)
        *end = false;
    if (returned_early)
        *returned_early = false;
    if (last_time)
        *last_time = seconds(c);
    return status;
}
