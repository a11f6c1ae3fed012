/* y = A u with n of them, a structural parameter in FMI 3; f = u[0] (1 ... 6), always 2 x 3. */

#include "model.h"

enum { U = 0, Y = 16, A = 32, F = 300, TIP = 320, SPAN = 321 };
enum { N };

static size_t count(const Values *v) { return v->i[N] < 16 ? (size_t)v->i[N] : 16; }

void model_start(Values *v) {
    v->i[N] = 2;
    for (int k = 0; k < 2; k++)
        v->r[A + 3 * k] = 1.0;
    v->next = HUGE_VAL;
    model_outputs(v);
}

void model_outputs(Values *v) {
    size_t n = count(v);
    for (size_t i = 0; i < n; i++) {
        v->r[Y + i] = 0.0;
        for (size_t j = 0; j < n; j++)
            v->r[Y + i] += v->r[A + i * n + j] * v->r[U + j];
    }
    for (int k = 0; k < 6; k++)
        v->r[F + k] = v->r[U] * (k + 1);
    v->r[TIP] = v->r[Y] + v->r[SPAN];
}

size_t model_size(const Values *v, unsigned reference) {
    size_t n = count(v);
    return reference == U || reference == Y ? n : reference == A ? n * n : reference == F ? 6 : 1;
}
