/* An instance of an exported component: what FMI 2 and FMI 3 share. */

#ifndef TOWLINE_CORE_H
#define TOWLINE_CORE_H

#include <stddef.h>
#include <stdint.h>

#define LOG_CATEGORY "logStatusError"

/* The codes of both standards. */
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED } Phase;

/* Where a variable's numbers are: one of the instance's vectors, or a table of constants. */
typedef enum { TIME, INPUT, OUTPUT, PARAMETER, REAL, INTEGER, BOOLEAN, TEXT } Block;

typedef struct {
    const char *name;
    Block block;
    size_t first, count;
} Variable;

/* What a parameter may be; an open bound is excluded. */
typedef struct {
    double low, high;
    int low_is_open, high_is_open, is_tunable, is_whole;
} Limit;

typedef struct {
    int64_t status;
    const char *text;
} StatusText;

/* Of the generated model.c, the only source that differs from model to model; value references index MODEL_VARIABLES.
   STEP_NS: the step that init is told; STEP_IS_FIXED: whether others are refused. */
extern const char MODEL_NAME[], MODEL_TOKEN[];
extern const size_t N_U, N_X, N_Y, N_Q, N_P, N_W, N_VARIABLES, N_STATUS_TEXTS;
extern const int64_t STEP_NS;
extern const int STEP_IS_FIXED;
extern const Variable MODEL_VARIABLES[];
extern const Limit MODEL_LIMITS[];
extern const StatusText MODEL_STATUS_TEXTS[];
extern const double MODEL_U[], MODEL_Q[], MODEL_P[], MODEL_REALS[];
extern const int64_t MODEL_INTEGERS[];
extern const int MODEL_BOOLEANS[];
extern const char *const MODEL_TEXTS[];
/* Write the numbers of p that depend on the settable parameters q. */
void model_parameters(const double *q, double *p);

/* All that a later step depends on, and the outputs: what is saved, restored and serialized. vectors: u, x, y, q and p,
   one after another. */
typedef struct {
    /* is_stale: init is to be called again before outputs are read; is_known: when it was last, it gave them */
    int64_t phase, has_stop, is_stale, is_known;
    int64_t t_ns, stop_ns;
    double vectors[];
} State;

/* u, x, y, q, p: where they are in the state; w: the workspace. log: passes a message on to the environment, in the words
   of its standard. */
typedef struct Instance {
    State *state;
    double *u, *x, *y, *q, *p, *w;
    char *name;
    void (*log)(struct Instance *, Status, const char *message);
    void (*callback)(void);
    void *environment;
} Instance;

Instance *instance_new(const char *name);
void instance_free(Instance *);
void instance_reset(Instance *);
/* Log a message about this instance and return the status. */
Status report(Instance *, Status, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Whether the phase is the one that the call `what` needs; else an error is logged. */
int is_in(Instance *, Phase, const char *what);

Status initialization_plan(Instance *, double start, int has_stop, double stop);
Status initialization_begin(Instance *);
Status initialization_end(Instance *);
Status step_to(Instance *, double t, double h);
Status terminate(Instance *);
/* Call init if the outputs of initialization mode are out of date; where it fails they are zero, and `failure` is logged
   and returned. */
Status initialize(Instance *, Status failure);
double seconds(const Instance *);

/* n value references, whose variables take n_values numbers in all. */
Status get_reals(Instance *, const uint32_t *references, size_t n, double *values, size_t n_values);
Status set_reals(Instance *, const uint32_t *references, size_t n, const double *values, size_t n_values);
/* The variable of a reference if it is in this block of constants; else an error is logged. */
const Variable *constant(Instance *, uint32_t reference, Block, const char *type);
Status is_given(Instance *, const void *references, size_t n, const void *values, const char *what);

/* The state is copied to where *state points, or to a new place if that is null. */
Status state_get(Instance *, State **state);
Status state_restore(Instance *, const State *);
Status state_free(State **state);
/* Bytes of a State in memory. */
size_t state_bytes(void);
Status state_size(size_t *size);
Status state_write(Instance *, const State *, char *bytes, size_t size);
Status state_read(Instance *, const char *bytes, size_t size, State **state);

#endif
