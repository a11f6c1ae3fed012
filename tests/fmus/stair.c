/* A counter that time events count up, and that ends the run at its last step. */

#include "model.h"

enum { INTERVAL };
enum { LEVEL, LAST };
#ifndef LAST_AT
#define LAST_AT 1000
#endif

static const double SLACK = 1e-12; /* s, of times that the importer adds up */

void model_start(Values *v) {
    v->r[INTERVAL] = 0.25;
    v->i[LAST] = LAST_AT;
    v->next = HUGE_VAL;
}

int model_event(Values *v) {
    if (v->next == HUGE_VAL)
        v->next = v->t + v->r[INTERVAL];
    while (v->next <= v->t + SLACK) {
        v->i[LEVEL]++;
        v->next += v->r[INTERVAL];
    }
    v->terminate = v->i[LEVEL] >= v->i[LAST];
    return 0;
}

Status model_step(Model *m, double h, int *event) {
    Values *v = &m->v;
    if (v->stops_at_events && v->next <= v->t + h + SLACK) {
        v->t = v->next;
        *event = 1;
        return OK;
    }
    v->t += h;
    *event = 0;
    if (!v->stops_at_events)
        model_event(v);
    return OK;
}
