/* A model that misbehaves as its parameters say: mode, where, and from which time on. */

#include "model.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { Y, AT, LARGEST, U };
enum { MODE, WHERE };
enum { FINE, WARNS, DISCARDS, FAILS, IS_FATAL, CRASHES, ABORTS, EXITS, SLEEPS, SPINS, NOT_FINITE, LOGS, NO_STATUS, SHORT_STEPS,
       KILLED, OVERFLOWS, NOISY };

void model_start(Values *v) {
    v->r[LARGEST] = 1.0;
    v->next = HUGE_VAL;
}

static volatile int *nowhere;

#pragma GCC diagnostic ignored "-Winfinite-recursion"
static int deeper(volatile int *above) {
    volatile int here[1000];
    here[0] = *above + 1;
    return deeper(here) + here[0];
}

Status model_trouble(Model *m, Place where) {
    Values *v = &m->v;
    if (v->i[WHERE] != where || v->t < v->r[AT] - 1e-9)
        return OK;
    volatile int start = 0;
    switch (v->i[MODE]) {
    case WARNS:
        core_log(m, WARNING, "a warning with 100 % of a percent sign");
        return WARNING;
    case DISCARDS:
        return DISCARD;
    case FAILS:
        core_log(m, ERROR, "the winch is on fire");
        return ERROR;
    case IS_FATAL:
        core_log(m, FATAL, "the winch is lost");
        return FATAL;
    case CRASHES:
        return (Status)*nowhere;
    case ABORTS:
        abort();
    case EXITS:
        _exit(3);
    case SLEEPS:
        for (;;)
            sleep(1000);
    case SPINS:
        for (;;)
            __asm__ volatile("");
    case NOT_FINITE:
        v->r[Y] = nan("");
        return OK;
    case LOGS:
        core_log(m, OK, "all is well\nin two lines");
        return OK;
    case NO_STATUS:
        return (Status)77;
    case KILLED:
        raise(SIGKILL);
        return OK;
    case OVERFLOWS:
        return (Status)deeper(&start);
    case NOISY:
        puts("the FMU speaks on standard output");
        fflush(stdout);
        return OK;
    }
    return OK;
}

Status model_step(Model *m, double h, int *event) {
    Values *v = &m->v;
    *event = 0;
    if (v->i[MODE] == SHORT_STEPS && h > v->r[LARGEST] * (1.0 + 1e-9)) {
        v->t += v->r[LARGEST];
        v->reached = v->t;
        return DISCARD;
    }
    v->t += h;
    if (v->i[MODE] != NOT_FINITE || v->t < v->r[AT] - 1e-9)
        v->r[Y] = v->t;
    else
        v->r[Y] = nan("");
    return OK;
}
