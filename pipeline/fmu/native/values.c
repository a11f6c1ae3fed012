/* Reading and writing an instance's variables by value reference. */

#include "core.h"

#include <math.h>
#include <string.h>

Status is_given(Instance *instance, const void *references, size_t n, const void *values, const char *what) {
    if (n > 0 && (!references || !values))
        return report(instance, ERROR, "%s: a null pointer where %zu variables are asked for", what, n);
    return OK;
}

static const Variable *variable(Instance *instance, uint32_t reference) {
    if (reference < N_VARIABLES)
        return &MODEL_VARIABLES[reference];
    report(instance, ERROR, "value reference %u; there are %zu variables", (unsigned)reference, N_VARIABLES);
    return NULL;
}

const Variable *constant(Instance *instance, uint32_t reference, Block block, const char *type) {
    const Variable *found = variable(instance, reference);
    if (found && found->block != block) {
        report(instance, ERROR, "%s is no variable of type %s", found->name, type);
        return NULL;
    }
    return found;
}

/* Whether the variables of the references take n_values numbers together. */
static int is_filled(Instance *instance, const uint32_t *references, size_t n, size_t n_values) {
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        const Variable *at = variable(instance, references[i]);
        if (!at)
            return 0;
        if (at->block > REAL) {
            report(instance, ERROR, "%s is no floating-point variable", at->name);
            return 0;
        }
        count += at->count;
    }
    if (count != n_values)
        report(instance, ERROR, "%zu values given for variables that hold %zu", n_values, count);
    return count == n_values;
}

/* A call of memcpy costs more than the few numbers that most variables hold. */
static void copy(double *to, const double *from, size_t count) {
    for (size_t k = 0; k < count; k++)
        to[k] = from[k];
}

/* What get reads. */
static const double *source(const Instance *instance, const Variable *at, const double *now) {
    switch (at->block) {
    case INPUT:
        return instance->u + at->first;
    case OUTPUT:
        return instance->y + at->first;
    case PARAMETER:
        return instance->q + at->first;
    case REAL:
        return MODEL_REALS + at->first;
    default:
        return now;
    }
}

/* Whether one of the variables is of the block. */
static int asks(Block block, const uint32_t *references, size_t n) {
    for (size_t i = 0; i < n; i++)
        if (MODEL_VARIABLES[references[i]].block == block)
            return 1;
    return 0;
}

/* In initialization mode a master may read before it has set all inputs, as libcosim does: outputs that init cannot give
   yet are zero then, with a warning, and leaving the mode is an error if it still cannot. */
Status get_reals(Instance *instance, const uint32_t *references, size_t n, double *values, size_t n_values) {
    Status status = OK;
    if (is_given(instance, references, n, values, "get") != OK || !is_filled(instance, references, n, n_values))
        return ERROR;
    if (instance->state->phase < STEPPING && asks(OUTPUT, references, n)) {
        if (instance->state->phase == INSTANTIATED)
            return report(instance, DISCARD, "outputs are known from initialization mode on");
        if (instance->state->phase == INITIALIZING)
            status = initialize(instance, WARNING);
    }
    double now = asks(TIME, references, n) ? seconds(instance) : 0.0;
    for (size_t i = 0; i < n; i++) {
        const Variable *at = &MODEL_VARIABLES[references[i]];
        copy(values, source(instance, at, &now), at->count);
        values += at->count;
    }
    return status;
}

static Status refuse(Instance *instance, const Variable *at, const char *why) {
    return report(instance, ERROR, "%s cannot be set: %s", at->name, why);
}

/* Whether a parameter may be set to the values. */
static Status allows(Instance *instance, const Variable *at, const double *values) {
    for (size_t k = 0; k < at->count; k++) {
        const Limit *limit = &MODEL_LIMITS[at->first + k];
        double value = values[k];
        if (!limit->is_tunable && instance->state->phase > INITIALIZING)
            return refuse(instance, at, "it is fixed once initialization mode is left");
        if (value < limit->low || (limit->low_is_open && value == limit->low))
            return report(instance, ERROR, "%s = %g; expected it %s %g", at->name, value,
                          limit->low_is_open ? "above" : "at least", limit->low);
        if (value > limit->high || (limit->high_is_open && value == limit->high))
            return report(instance, ERROR, "%s = %g; expected it %s %g", at->name, value,
                          limit->high_is_open ? "below" : "at most", limit->high);
        if (limit->is_whole && value != floor(value))
            return report(instance, ERROR, "%s = %g; expected a whole number", at->name, value);
    }
    return OK;
}

static Status may_set(Instance *instance, const Variable *at, const double *values) {
    if (at->block != INPUT && at->block != PARAMETER)
        return refuse(instance, at, at->block == REAL ? "it was fixed when the FMU was built" : "the FMU computes it");
    for (size_t k = 0; k < at->count; k++)
        if (!isfinite(values[k]))
            return report(instance, ERROR, "%s = %g; expected a finite number", at->name, values[k]);
    return at->block == PARAMETER ? allows(instance, at, values) : OK;
}

/* Write those of the values that are of the block. */
static void write(Instance *instance, Block block, const uint32_t *references, size_t n, const double *values) {
    double *vector = block == INPUT ? instance->u : instance->q;
    for (size_t i = 0; i < n; i++) {
        const Variable *at = &MODEL_VARIABLES[references[i]];
        if (at->block == block)
            copy(vector + at->first, values, at->count);
        values += at->count;
    }
}

/* Set parameters and what follows from them; values whose p would not be finite are taken back. */
static Status set_parameters(Instance *instance, const uint32_t *references, size_t n, const double *values) {
    if (!asks(PARAMETER, references, n))
        return OK;
    double before[N_Q];
    memcpy(before, instance->q, sizeof before);
    write(instance, PARAMETER, references, n, values);
    model_parameters(instance->q, instance->p);
    for (size_t i = 0; i < N_P; i++)
        if (!isfinite(instance->p[i])) {
            memcpy(instance->q, before, sizeof before);
            model_parameters(instance->q, instance->p);
            return report(instance, ERROR, "with these parameters a number of the model is not finite");
        }
    return OK;
}

/* All of the values are set, or none. */
Status set_reals(Instance *instance, const uint32_t *references, size_t n, const double *values, size_t n_values) {
    State *state = instance->state;
    if (is_given(instance, references, n, values, "set") != OK || !is_filled(instance, references, n, n_values))
        return ERROR;
    for (size_t i = 0, k = 0; i < n; k += MODEL_VARIABLES[references[i++]].count)
        if (may_set(instance, &MODEL_VARIABLES[references[i]], values + k) != OK)
            return ERROR;
    if (set_parameters(instance, references, n, values) != OK)
        return ERROR;
    write(instance, INPUT, references, n, values);
    state->is_stale = state->phase == INITIALIZING;
    return OK;
}
