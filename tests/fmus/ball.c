/* A ball that bounces: free flight in closed form, a state event at each impact, at rest below a least speed. */

#include "model.h"

#include <float.h>

enum { H, V, G, E, LEAST, DH, DV, Z };
enum { BOUNCES };
enum { RESTING };

size_t N_STATES = 2, N_INDICATORS = 1;

void model_start(Values *v) {
    v->r[H] = 1.0;
    v->r[G] = 9.81;
    v->r[E] = 0.7;
    v->r[LEAST] = 0.1;
    v->next = HUGE_VAL;
    model_outputs(v);
}

void model_derivatives(const Values *v, double *dx) {
    dx[0] = v->b[RESTING] ? 0.0 : v->r[V];
    dx[1] = v->b[RESTING] ? 0.0 : -v->r[G];
}

void model_indicators(const Values *v, double *z) { z[0] = v->b[RESTING] ? 1.0 : v->r[H]; }

void model_outputs(Values *v) {
    model_derivatives(v, &v->r[DH]);
    model_indicators(v, &v->r[Z]);
}

int model_event(Values *v) {
    if (v->b[RESTING] || v->r[H] > 0.0 || v->r[V] >= 0.0)
        return 0;
    v->r[H] = DBL_MIN; /* not on the ground, whose crossing would be met again */
    v->r[V] *= -v->r[E];
    v->i[BOUNCES]++;
    if (v->r[V] < v->r[LEAST]) {
        v->r[V] = 0.0;
        v->b[RESTING] = 1;
    }
    return 1;
}

static void fly(Values *v, double dt) {
    v->t += dt;
    if (v->b[RESTING])
        return;
    v->r[H] += (v->r[V] - 0.5 * v->r[G] * dt) * dt;
    v->r[V] -= v->r[G] * dt;
}

Status model_step(Model *m, double h, int *event) {
    Values *v = &m->v;
    double end = v->t + h;
    *event = 0;
    while (!v->b[RESTING]) {
        double flight = (v->r[V] + sqrt(v->r[V] * v->r[V] + 2.0 * v->r[G] * v->r[H])) / v->r[G];
        if (v->t + flight > end)
            break;
        fly(v, flight);
        v->r[H] = 0.0;
        if (v->stops_at_events) {
            *event = 1;
            return OK;
        }
        model_event(v);
    }
    fly(v, end - v->t);
    v->t = end;
    return OK;
}
