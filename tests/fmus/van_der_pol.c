/* Van der Pol's oscillator: x' = v, v' = mu (1 - x^2) v - x + coupling (neighbour - x). */

#include "model.h"

enum { X, V, MU, COUPLING, NEIGHBOUR, DX, DV };

size_t N_STATES = 2, N_INDICATORS = 0;

void model_start(Values *v) {
    v->r[X] = 2.0;
    v->r[MU] = 1.0;
    v->next = HUGE_VAL;
    model_outputs(v);
}

void model_derivatives(const Values *v, double *dx) {
    const double *r = v->r;
    dx[0] = r[V];
    dx[1] = r[MU] * (1.0 - r[X] * r[X]) * r[V] - r[X] + r[COUPLING] * (r[NEIGHBOUR] - r[X]);
}

void model_outputs(Values *v) { model_derivatives(v, &v->r[DX]); }
