/* What a test's FMU is, whatever the version of FMI: its values, and what the model does with them. */

#ifndef MODEL_H
#define MODEL_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

/* First value references of each type; a value reference names the first slot of an array. */
enum { REAL = 0, INTEGER = 1000, BOOLEAN = 2000, TEXT = 3000, BINARY = 4000 };
enum { REALS = 600, INTEGERS = 32, BOOLEANS = 16, TEXTS = 8, BINARIES = 4, LENGTH = 256, TIME = REALS - 1 };

/* The same numbers in FMI 1, 2 and 3. */
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

/* Where model_trouble is called. */
typedef enum { IN_STEP, IN_START, AFTER_START, IN_GET, IN_SET, IN_TERMINATE, IN_FREE } Place;

typedef struct {
    double r[REALS];
    int64_t i[INTEGERS];
    int b[BOOLEANS];
    char s[TEXTS][LENGTH];
    unsigned char bytes[BINARIES][LENGTH];
    size_t n_bytes[BINARIES];
    double t, next;       /* time, and that of the next time event */
    double reached;       /* last successful time of a discarded step */
    int terminate;        /* the model wants to end the run */
    int stops_at_events;  /* FMI 3: return early and let the importer handle the event */
} Values;

typedef struct {
    Values v;
    void (*log)(void *instance, Status, const char *text);
    char name[LENGTH];
} Model;

/* The first N_STATES reals are the continuous states. */
extern size_t N_STATES, N_INDICATORS;

void model_start(Values *);                                 /* default values */
void model_outputs(Values *);                               /* what follows from states, inputs and parameters */
void model_derivatives(const Values *, double *dx);
void model_indicators(const Values *, double *z);
int model_event(Values *);                                  /* handle what is due; 1: continuous states jumped */
Status model_step(Model *, double h, int *event);           /* advance v.t, at most by h; event: it stopped at one */
size_t model_size(const Values *, unsigned reference);      /* values behind a reference */
Status model_trouble(Model *, Place);                       /* misbehave, if told so */

/* core.c */
int core_may_be_made(const char *token);
Status core_step(Model *, double t, double h, int *event);
void core_log(Model *, Status, const char *text);

#endif
