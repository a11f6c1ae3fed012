/* A variable of every type, fed through; what a text or bytes hold is told as a number. */

#include "model.h"

#include <string.h>

enum { REAL_IN, REAL_OUT, GAIN, OFFSET, SHORT_IN, SHORT_OUT };
enum { INT_IN, INT_OUT, COUNT, CHOICE_IN, CHOICE_OUT, CHOICE, TEXT_LENGTH, BYTE_SUM, LARGE, LARGE_OUT, WIDE_IN, WIDE_OUT = 20 };
enum { ON_IN, ON_OUT, ON };
enum { NAME, TEXT_OUT, TEXT_IN };

void model_start(Values *v) {
    v->r[GAIN] = 1.0;
    v->i[CHOICE] = 1;
    v->i[CHOICE_IN] = 1;
    strcpy(v->s[NAME], "none");
    v->bytes[0][1] = 0xff;
    v->n_bytes[0] = 2;
    v->next = HUGE_VAL;
    model_outputs(v);
}

void model_outputs(Values *v) {
    v->r[REAL_OUT] = v->r[GAIN] * v->r[REAL_IN] + v->r[OFFSET];
    v->r[SHORT_OUT] = v->r[SHORT_IN];
    v->i[INT_OUT] = v->i[INT_IN] + v->i[COUNT];
    v->i[CHOICE_OUT] = v->i[CHOICE] == 1 ? v->i[CHOICE_IN] : v->i[CHOICE];
    v->i[LARGE_OUT] = v->i[LARGE];
    for (int k = 0; k < 8; k++) /* Int8 to UInt64 */
        v->i[WIDE_OUT + k] = v->i[WIDE_IN + k];
    v->b[ON_OUT] = v->b[ON_IN] != v->b[ON];
    v->i[TEXT_LENGTH] = (int64_t)strlen(v->s[NAME]);
    v->i[BYTE_SUM] = 0;
    for (size_t k = 0; k < v->n_bytes[0]; k++)
        v->i[BYTE_SUM] += v->bytes[0][k];
    strcpy(v->s[TEXT_OUT], v->t < 0.05 ? v->s[NAME] : "changed");
}
