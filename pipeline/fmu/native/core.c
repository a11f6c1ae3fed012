/* The life of an instance: initialization, steps, time, messages. */

#include "core.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The component's machine code: its status, and a result that is not zero if it failed to give one. */
typedef int32_t Kernel(int64_t *status, void **failure, int64_t t_ns, int64_t dt_ns, double *p, double *u, double *x,
                       double *y, double *w);
extern Kernel kernel_init, kernel_step;

/* Communication points are doubles that a master may have added up: over a day of 1 ms steps that drifts by less. */
static const double DRIFT_NS = 1000.0;
static const double NS = 1e9;
static const double LATEST_NS = 9.2e18; /* int64 reaches to 9.22e18 */

enum { LONGEST_MESSAGE = 1024 };

Instance *instance_new(const char *name) {
    Instance *instance = calloc(1, sizeof *instance);
    size_t length = name ? strlen(name) + 1 : 1;
    if (!instance)
        return NULL;
    instance->name = calloc(1, length);
    instance->state = calloc(1, state_bytes());
    instance->w = calloc(N_W > 0 ? N_W : 1, sizeof(double));
    if (!instance->name || !instance->state || !instance->w) {
        instance_free(instance);
        return NULL;
    }
    if (name)
        memcpy(instance->name, name, length);
    instance->u = instance->state->vectors;
    instance->x = instance->u + N_U;
    instance->y = instance->x + N_X;
    instance->q = instance->y + N_Y;
    instance->p = instance->q + N_Q;
    instance_reset(instance);
    return instance;
}

void instance_free(Instance *instance) {
    if (!instance)
        return;
    free(instance->w);
    free(instance->state);
    free(instance->name);
    free(instance);
}

void instance_reset(Instance *instance) {
    memset(instance->state, 0, state_bytes());
    memcpy(instance->u, MODEL_U, N_U * sizeof(double));
    memcpy(instance->q, MODEL_Q, N_Q * sizeof(double));
    memcpy(instance->p, MODEL_P, N_P * sizeof(double));
    instance->state->phase = INSTANTIATED;
}

Status report(Instance *instance, Status status, const char *format, ...) {
    char message[LONGEST_MESSAGE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (instance->log)
        instance->log(instance, status, message);
    return status;
}

int is_in(Instance *instance, Phase phase, const char *what) {
    static const char *const NAMES[] = {"before initialization mode", "in initialization mode", "between steps",
                                        "after termination", "after an error"};
    if (instance->state->phase == (int64_t)phase)
        return 1;
    report(instance, ERROR, "%s %s; it may be called %s only", what, NAMES[instance->state->phase], NAMES[phase]);
    return 0;
}

double seconds(const Instance *instance) {
    return (double)instance->state->t_ns / NS;
}

/* The nearest nanosecond; false where there is none. */
static int nanoseconds(double t, int64_t *ns) {
    double scaled = t * NS;
    if (!isfinite(scaled) || fabs(scaled) > LATEST_NS)
        return 0;
    *ns = llround(scaled);
    return 1;
}

static const char *text_of(int64_t status) {
    for (size_t i = 0; i < N_STATUS_TEXTS; i++)
        if (MODEL_STATUS_TEXTS[i].status == status)
            return MODEL_STATUS_TEXTS[i].text;
    return "no text is known for it";
}

/* The output that holds y[i]. */
static const Variable *output_at(size_t i) {
    for (size_t v = 0; v < N_VARIABLES; v++) {
        const Variable *variable = &MODEL_VARIABLES[v];
        if (variable->block == OUTPUT && i >= variable->first && i < variable->first + variable->count)
            return variable;
    }
    return NULL;
}

/* failure: what is logged and returned where there are no outputs. */
static Status call(Instance *instance, Kernel *kernel, Status failure, int64_t t_ns, int64_t dt_ns) {
    int64_t status = 0;
    void *raised = NULL;
    double t = (double)t_ns / NS;
    int32_t code = kernel(&status, &raised, t_ns, dt_ns, instance->p, instance->u, instance->x, instance->y, instance->w);
    if (code != 0)
        return report(instance, failure, "%s failed at t = %.9f s (code %d)", MODEL_NAME, t, (int)code);
    if (status != 0)
        return report(instance, failure, "%s stopped at t = %.9f s with status %lld: %s", MODEL_NAME, t,
                      (long long)status, text_of(status));
    for (size_t i = 0; i < N_Y; i++)
        if (!isfinite(instance->y[i])) {
            const Variable *at = output_at(i);
            return report(instance, failure, "output %s is %g at t = %.9f s", at ? at->name : "?", instance->y[i], t);
        }
    return OK;
}

Status initialization_plan(Instance *instance, double start, int has_stop, double stop) {
    State *state = instance->state;
    if (!is_in(instance, INSTANTIATED, "setting up the experiment"))
        return ERROR;
    if (!nanoseconds(start, &state->t_ns))
        return report(instance, ERROR, "start time %g s; expected a finite one, within 292 years", start);
    state->has_stop = has_stop && nanoseconds(stop, &state->stop_ns);
    if (state->has_stop && state->stop_ns < state->t_ns)
        return report(instance, ERROR, "stop time %.9f s is before the start time %.9f s", stop, start);
    return OK;
}

Status initialization_begin(Instance *instance) {
    if (!is_in(instance, INSTANTIATED, "entering initialization mode"))
        return ERROR;
    instance->state->phase = INITIALIZING;
    instance->state->is_stale = 1;
    return OK;
}

Status initialize(Instance *instance, Status failure) {
    State *state = instance->state;
    if (state->is_stale) {
        memset(instance->x, 0, N_X * sizeof(double));
        memset(instance->y, 0, N_Y * sizeof(double));
        state->is_known = call(instance, kernel_init, failure, state->t_ns, STEP_NS) == OK;
        if (!state->is_known)
            memset(instance->y, 0, N_Y * sizeof(double));
        if (!state->is_known && failure == WARNING)
            report(instance, WARNING, "the outputs are zero until inputs and parameters are set with which they are known");
        state->is_stale = 0;
    }
    return state->is_known ? OK : failure;
}

Status initialization_end(Instance *instance) {
    State *state = instance->state;
    if (!is_in(instance, INITIALIZING, "leaving initialization mode"))
        return ERROR;
    if (!state->is_known)
        state->is_stale = 1; /* what was a warning is told as the error that it is now */
    Status status = initialize(instance, ERROR);
    state->phase = status == OK ? STEPPING : FAILED;
    return status;
}

Status step_to(Instance *instance, double t, double h) {
    State *state = instance->state;
    int64_t from_ns, end_ns;
    if (!is_in(instance, STEPPING, "a step"))
        return ERROR;
    if (!(h > 0.0))
        return report(instance, ERROR, "step of %g s; expected one above zero", h);
    if (!nanoseconds(t, &from_ns) || !nanoseconds(t + h, &end_ns))
        return report(instance, ERROR, "step of %g s from %g s; times reach to 292 years", h, t);
    if (fabs((double)(from_ns - state->t_ns)) > DRIFT_NS)
        return report(instance, ERROR, "step from %.9f s, but the last one ended at %.9f s", t, seconds(instance));
    if (end_ns <= state->t_ns)
        return report(instance, ERROR, "step of %g s; the shortest is 1 ns", h);
    if (state->has_stop && (double)(end_ns - state->stop_ns) > DRIFT_NS)
        return report(instance, ERROR, "step to %.9f s, beyond the stop time %.9f s", t + h, (double)state->stop_ns / NS);
    int64_t dt_ns = end_ns - state->t_ns;
    if (STEP_IS_FIXED && llabs(dt_ns - STEP_NS) > 1)
        return report(instance, ERROR, "step of %g s; its force laws need %.9f s throughout", h, (double)STEP_NS / NS);
    Status status = call(instance, kernel_step, ERROR, end_ns, dt_ns);
    if (status != OK) {
        state->phase = FAILED;
        return status;
    }
    state->t_ns = end_ns;
    return OK;
}

Status terminate(Instance *instance) {
    instance->state->phase = TERMINATED;
    return OK;
}
