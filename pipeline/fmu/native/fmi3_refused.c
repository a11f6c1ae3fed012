/* The functions of FMI 3.0 that have nothing to do here: types without variables, clocks, events, other interfaces.

   A master may load all of the standard's functions, so that none may be missing. */

#include "core.h"

#include <stdbool.h>

#define EXPORT __attribute__((visibility("default")))

typedef const uint32_t References[];
typedef void Callback(void);
typedef void LogMessage(void *environment, Status, const char *category, const char *message);

/* What asks for nothing (n = 0) is granted. */
static Status refuse(Instance *c, size_t n, const char *why) {
    if (!c)
        return ERROR;
    return n == 0 ? OK : report(c, ERROR, "%s", why);
}

#define NONE_OF(Type, ctype)                                                                                           \
    EXPORT Status fmi3Get##Type(Instance *c, References references, size_t n, ctype values[], size_t n_values) {       \
        return refuse(c, n, "there are no variables of type " #Type);                                                  \
    }                                                                                                                  \
    EXPORT Status fmi3Set##Type(Instance *c, References references, size_t n, ctype const values[], size_t n_values) { \
        return refuse(c, n, "there are no variables of type " #Type);                                                  \
    }

NONE_OF(Float32, float)
NONE_OF(Int8, int8_t)
NONE_OF(UInt8, uint8_t)
NONE_OF(Int16, int16_t)
NONE_OF(UInt16, uint16_t)
NONE_OF(Int32, int32_t)
NONE_OF(UInt32, uint32_t)
NONE_OF(UInt64, uint64_t)

/* A function by its name, its arguments after the instance, how many things it asks for, and why it gives none. */
#define REFUSED(function, arguments, n, why)                                                                           \
    EXPORT Status function arguments {                                                                                 \
        return refuse(c, n, why);                                                                                      \
    }

#define NO_BINARY "there are no variables of type Binary"
REFUSED(fmi3GetBinary,
        (Instance *c, References references, size_t n, size_t sizes[], const uint8_t *values[], size_t n_values), n,
        NO_BINARY)
REFUSED(fmi3SetBinary,
        (Instance *c, References references, size_t n, const size_t sizes[], const uint8_t *const values[],
         size_t n_values),
        n, NO_BINARY)

#define NO_CLOCKS "there are no clocks"
REFUSED(fmi3GetClock, (Instance *c, References references, size_t n, bool values[]), n, NO_CLOCKS)
REFUSED(fmi3SetClock, (Instance *c, References references, size_t n, const bool values[]), n, NO_CLOCKS)
REFUSED(fmi3GetIntervalDecimal, (Instance *c, References references, size_t n, double intervals[], int qualifiers[]), n,
        NO_CLOCKS)
REFUSED(fmi3GetIntervalFraction,
        (Instance *c, References references, size_t n, uint64_t counters[], uint64_t resolutions[], int qualifiers[]),
        n, NO_CLOCKS)
REFUSED(fmi3GetShiftDecimal, (Instance *c, References references, size_t n, double shifts[]), n, NO_CLOCKS)
REFUSED(fmi3GetShiftFraction,
        (Instance *c, References references, size_t n, uint64_t counters[], uint64_t resolutions[]), n, NO_CLOCKS)
REFUSED(fmi3SetIntervalDecimal, (Instance *c, References references, size_t n, const double intervals[]), n, NO_CLOCKS)
REFUSED(fmi3SetIntervalFraction,
        (Instance *c, References references, size_t n, const uint64_t counters[], const uint64_t resolutions[]), n,
        NO_CLOCKS)
REFUSED(fmi3SetShiftDecimal, (Instance *c, References references, size_t n, const double shifts[]), n, NO_CLOCKS)
REFUSED(fmi3SetShiftFraction,
        (Instance *c, References references, size_t n, const uint64_t counters[], const uint64_t resolutions[]), n,
        NO_CLOCKS)
REFUSED(fmi3ActivateModelPartition, (Instance *c, uint32_t reference, double t), 1, NO_CLOCKS)

#define NO_EVENTS "there is no event mode"
REFUSED(fmi3EnterEventMode, (Instance *c), 1, NO_EVENTS)
REFUSED(fmi3EnterStepMode, (Instance *c), 1, NO_EVENTS)
REFUSED(fmi3EvaluateDiscreteStates, (Instance *c), 1, NO_EVENTS)
REFUSED(fmi3UpdateDiscreteStates,
        (Instance *c, bool *need_update, bool *end, bool *nominals, bool *values, bool *has_next, double *next), 1,
        NO_EVENTS)

#define NO_CONFIGURATION "there is no configuration mode: sizes were fixed when the FMU was built"
REFUSED(fmi3EnterConfigurationMode, (Instance *c), 1, NO_CONFIGURATION)
REFUSED(fmi3ExitConfigurationMode, (Instance *c), 1, NO_CONFIGURATION)

#define NO_DERIVATIVES "no derivatives and no dependencies of single numbers are provided"
REFUSED(fmi3GetNumberOfVariableDependencies, (Instance *c, uint32_t reference, size_t *n), 1, NO_DERIVATIVES)
REFUSED(fmi3GetVariableDependencies,
        (Instance *c, uint32_t reference, size_t dependent[], uint32_t independent[], size_t element[], int kinds[],
         size_t n),
        1, NO_DERIVATIVES)
REFUSED(fmi3GetDirectionalDerivative,
        (Instance *c, References unknowns, size_t n, References knowns, size_t n_knowns, const double seed[],
         size_t n_seed, double sensitivity[], size_t n_sensitivity),
        n, NO_DERIVATIVES)
REFUSED(fmi3GetAdjointDerivative,
        (Instance *c, References unknowns, size_t n, References knowns, size_t n_knowns, const double seed[],
         size_t n_seed, double sensitivity[], size_t n_sensitivity),
        n, NO_DERIVATIVES)
REFUSED(fmi3GetOutputDerivatives,
        (Instance *c, References references, size_t n, const int32_t orders[], double values[], size_t n_values), n,
        NO_DERIVATIVES)

#define ONLY_CO_SIMULATION "this FMU is for co-simulation only"
REFUSED(fmi3EnterContinuousTimeMode, (Instance *c), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3CompletedIntegratorStep, (Instance *c, bool no_going_back, bool *event, bool *end), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3SetTime, (Instance *c, double t), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3SetContinuousStates, (Instance *c, const double x[], size_t n), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3GetContinuousStates, (Instance *c, double x[], size_t n), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3GetContinuousStateDerivatives, (Instance *c, double derivatives[], size_t n), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3GetNominalsOfContinuousStates, (Instance *c, double nominals[], size_t n), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3GetEventIndicators, (Instance *c, double indicators[], size_t n), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3GetNumberOfEventIndicators, (Instance *c, size_t *n), 1, ONLY_CO_SIMULATION)
REFUSED(fmi3GetNumberOfContinuousStates, (Instance *c, size_t *n), 1, ONLY_CO_SIMULATION)

EXPORT Instance *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible,
                                              bool logging_on, void *environment, LogMessage *logger) {
    if (logger)
        logger(environment, ERROR, LOG_CATEGORY, ONLY_CO_SIMULATION);
    return NULL;
}

EXPORT Instance *fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources,
                                                   bool visible, bool logging_on, void *environment,
                                                   LogMessage *logger, Callback *update, Callback *lock,
                                                   Callback *unlock) {
    if (logger)
        logger(environment, ERROR, LOG_CATEGORY, ONLY_CO_SIMULATION);
    return NULL;
}
