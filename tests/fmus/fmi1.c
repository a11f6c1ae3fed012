/* FMI 1.0 for co-simulation around a model; PREFIX is its identifier. */

#include "model.h"

#include "fmi1Functions.h"

#include <stdlib.h>
#include <string.h>

#define JOINED(prefix, name) prefix##_##name
#define NAMED(prefix, name) JOINED(prefix, name)
#define F(name) NAMED(PREFIX, name)

typedef struct {
    Model m;
    fmi1CallbackFunctions callbacks;
} Instance;

static void forward(void *c, Status status, const char *text) {
    Instance *one = c;
    if (one->callbacks.logger)
        one->callbacks.logger(c, one->m.name, (fmi1Status)status, "log", "%s", text);
}

static fmi1Status of(Status status) { return (fmi1Status)status; }

const char *F(fmiGetTypesPlatform)(void) { return "standard32"; }
const char *F(fmiGetVersion)(void) { return "1.0"; }
fmi1Status F(fmiSetDebugLogging)(fmi1Component c, fmi1Boolean on) { return (void)c, (void)on, fmi1OK; }

fmi1Component F(fmiInstantiateSlave)(fmi1String name, fmi1String token, fmi1String place, fmi1String mime,
                                     fmi1Real timeout, fmi1Boolean visible, fmi1Boolean interactive,
                                     fmi1CallbackFunctions callbacks, fmi1Boolean logs) {
    (void)place, (void)mime, (void)timeout, (void)visible, (void)interactive, (void)logs;
    Instance *one = core_may_be_made(token) ? calloc(1, sizeof *one) : NULL;
    if (!one)
        return NULL;
    one->m.log = forward;
    one->callbacks = callbacks;
    strncpy(one->m.name, name, LENGTH - 1);
    model_start(&one->m.v);
    return one;
}

fmi1Status F(fmiInitializeSlave)(fmi1Component c, fmi1Real start, fmi1Boolean has_stop, fmi1Real stop) {
    (void)has_stop, (void)stop;
    Model *m = c;
    m->v.t = start;
    Status status = model_trouble(m, IN_START);
    if (status <= WARNING) {
        model_event(&m->v);
        model_outputs(&m->v);
        status = model_trouble(m, AFTER_START);
    }
    return of(status);
}

fmi1Status F(fmiTerminateSlave)(fmi1Component c) { return of(model_trouble(c, IN_TERMINATE)); }

fmi1Status F(fmiResetSlave)(fmi1Component c) {
    Model *m = c;
    memset(&m->v, 0, sizeof m->v);
    model_start(&m->v);
    return fmi1OK;
}

void F(fmiFreeSlaveInstance)(fmi1Component c) {
    if (c)
        model_trouble(c, IN_FREE);
    free(c);
}

fmi1Status F(fmiDoStep)(fmi1Component c, fmi1Real t, fmi1Real h, fmi1Boolean is_new) {
    (void)is_new;
    int event;
    return of(core_step(c, t, h, &event));
}

#define ACCESS(Name, Type, array, FIRST, MOST)                                                          \
    fmi1Status F(fmiGet##Name)(fmi1Component c, const fmi1ValueReference vr[], size_t n, Type value[]) { \
        Model *m = c;                                                                                   \
        Status status = model_trouble(m, IN_GET);                                                       \
        for (size_t k = 0; k < n; k++) {                                                                \
            if (vr[k] - FIRST >= MOST)                                                                  \
                return fmi1Error;                                                                       \
            value[k] = (Type)m->v.array[vr[k] - FIRST];                                                 \
        }                                                                                               \
        return of(status);                                                                              \
    }

#define CHANGE(Name, Type, array, FIRST, MOST, ...)                                                           \
    fmi1Status F(fmiSet##Name)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const Type value[]) { \
        Model *m = c;                                                                                         \
        Status status = model_trouble(m, IN_SET);                                                             \
        for (size_t k = 0; k < n; k++) {                                                                      \
            if (vr[k] - FIRST >= MOST)                                                                        \
                return fmi1Error;                                                                             \
            __VA_ARGS__;                                                                                      \
        }                                                                                                     \
        model_outputs(&m->v);                                                                                 \
        return of(status);                                                                                    \
    }

ACCESS(Real, fmi1Real, r, REAL, REALS)
ACCESS(Integer, fmi1Integer, i, INTEGER, INTEGERS)
ACCESS(Boolean, fmi1Boolean, b, BOOLEAN, BOOLEANS)
ACCESS(String, fmi1String, s, TEXT, TEXTS)
CHANGE(Real, fmi1Real, r, REAL, REALS, m->v.r[vr[k] - REAL] = value[k])
CHANGE(Integer, fmi1Integer, i, INTEGER, INTEGERS, m->v.i[vr[k] - INTEGER] = value[k])
CHANGE(Boolean, fmi1Boolean, b, BOOLEAN, BOOLEANS, m->v.b[vr[k] - BOOLEAN] = value[k])
CHANGE(String, fmi1String, s, TEXT, TEXTS, strncpy(m->v.s[vr[k] - TEXT], value[k], LENGTH - 1))

fmi1Status F(fmiSetRealInputDerivatives)(fmi1Component c, const fmi1ValueReference vr[], size_t n,
                                         const fmi1Integer order[], const fmi1Real value[]) {
    return (void)c, (void)vr, (void)n, (void)order, (void)value, fmi1Error;
}

fmi1Status F(fmiGetRealOutputDerivatives)(fmi1Component c, const fmi1ValueReference vr[], size_t n,
                                          const fmi1Integer order[], fmi1Real value[]) {
    return (void)c, (void)vr, (void)n, (void)order, (void)value, fmi1Error;
}

fmi1Status F(fmiCancelStep)(fmi1Component c) { return (void)c, fmi1Error; }

fmi1Status F(fmiGetRealStatus)(fmi1Component c, const fmi1StatusKind kind, fmi1Real *value) {
    *value = ((Model *)c)->v.reached;
    return kind == fmi1LastSuccessfulTime ? fmi1OK : fmi1Discard;
}

#define NOT_TOLD(Name, Type)                                                                   \
    fmi1Status F(fmiGet##Name)(fmi1Component c, const fmi1StatusKind kind, Type *value) { \
        return (void)c, (void)kind, (void)value, fmi1Discard;                                  \
    }

NOT_TOLD(Status, fmi1Status)
NOT_TOLD(IntegerStatus, fmi1Integer)
NOT_TOLD(BooleanStatus, fmi1Boolean)
NOT_TOLD(StringStatus, fmi1String)
