/* What all test FMUs do alike; a model gives its own for any of the weak functions. */

#include "model.h"

#include <stdio.h>
#include <string.h>

#define DEFAULT __attribute__((weak))

DEFAULT size_t N_STATES = 0, N_INDICATORS = 0;

DEFAULT void model_start(Values *v) { (void)v; }
DEFAULT void model_outputs(Values *v) { (void)v; }
DEFAULT void model_derivatives(const Values *v, double *dx) { (void)v, (void)dx; }
DEFAULT void model_indicators(const Values *v, double *z) { (void)v, (void)z; }
DEFAULT int model_event(Values *v) { return (void)v, 0; }
DEFAULT size_t model_size(const Values *v, unsigned reference) { return (void)v, (void)reference, 1; }
DEFAULT Status model_trouble(Model *m, Place where) { return (void)m, (void)where, OK; }

/* One step of the classical Runge-Kutta method, inputs held. */
DEFAULT Status model_step(Model *m, double h, int *event) {
    enum { MOST = 8 };
    double x[MOST], k[4][MOST];
    const double at[4] = {0.0, 0.5, 0.5, 1.0};
    memcpy(x, m->v.r, N_STATES * sizeof *x);
    for (int stage = 0; stage < 4; stage++) {
        for (size_t i = 0; i < N_STATES; i++)
            m->v.r[i] = x[i] + (stage ? at[stage] * h * k[stage - 1][i] : 0.0);
        model_derivatives(&m->v, k[stage]);
    }
    for (size_t i = 0; i < N_STATES; i++)
        m->v.r[i] = x[i] + h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
    m->v.t += h;
    *event = 0;
    return OK;
}

/* MODEL_TOKEN: the GUID that the binary knows; ONCE: a second instance in the process is refused. */
int core_may_be_made(const char *token) {
#ifdef ONCE
    static int made;
    if (made++)
        return 0;
#endif
#ifdef AT_INSTANTIATION
    AT_INSTANTIATION;
#endif
    return token && strcmp(token, MODEL_TOKEN) == 0;
}

Status core_step(Model *m, double t, double h, int *event) {
    *event = 0;
    m->v.reached = t;
    Status status = model_trouble(m, IN_STEP);
    if (status > WARNING)
        return status;
#ifdef FIXED_STEP
    if (fabs(h - FIXED_STEP) > 1e-12) {
        core_log(m, ERROR, "steps of another length than the fixed one");
        return ERROR;
    }
#endif
    if (fabs(t - m->v.t) > 1e-9) {
        char text[LENGTH];
        snprintf(text, sizeof text, "a step from %.17g, where the time is %.17g", t, m->v.t);
        core_log(m, ERROR, text);
        return ERROR;
    }
    Status stepped = model_step(m, h, event);
    model_outputs(&m->v);
    return stepped > status ? stepped : status;
}

void core_log(Model *m, Status status, const char *text) {
    if (m->log)
        m->log(m, status, text);
}

#ifdef AT_LOADING
__attribute__((constructor)) static void loading(void) { AT_LOADING; }
#endif
