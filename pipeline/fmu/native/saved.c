/* Saving, restoring and serializing an instance's state. */

#include "core.h"

#include <stdlib.h>
#include <string.h>

/* Before the state's bytes: whose they are, and a check of them. */
typedef struct {
    char token[40];
    uint64_t check;
} Heading;

size_t state_bytes(void) {
    return sizeof(State) + (N_U + N_X + N_Y + N_Q + N_P) * sizeof(double);
}

static size_t serialized_bytes(void) {
    return sizeof(Heading) + state_bytes();
}

Status state_get(Instance *instance, State **state) {
    if (!state)
        return ERROR;
    State *saved = *state ? *state : malloc(state_bytes());
    if (!saved)
        return report(instance, ERROR, "no memory for a state of %zu bytes", state_bytes());
    memcpy(saved, instance->state, state_bytes());
    *state = saved;
    return OK;
}

Status state_restore(Instance *instance, const State *state) {
    if (!state)
        return report(instance, ERROR, "no state is given to restore");
    memcpy(instance->state, state, state_bytes());
    return OK;
}

Status state_free(State **state) {
    if (!state)
        return ERROR;
    free(*state);
    *state = NULL;
    return OK;
}

Status state_size(size_t *size) {
    if (!size)
        return ERROR;
    *size = serialized_bytes();
    return OK;
}

/* FNV-1a, 64 bits. */
static uint64_t check_of(const State *state) {
    const unsigned char *bytes = (const unsigned char *)state;
    size_t n = state_bytes();
    uint64_t hash = 14695981039346656037u;
    for (size_t i = 0; i < n; i++)
        hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}

static Heading heading_of(const State *state) {
    Heading heading;
    memset(&heading, 0, sizeof heading);
    strncpy(heading.token, MODEL_TOKEN, sizeof heading.token - 1);
    heading.check = check_of(state);
    return heading;
}

Status state_write(Instance *instance, const State *state, char *bytes, size_t size) {
    if (!state || !bytes || size < serialized_bytes())
        return report(instance, ERROR, "no state, or %zu bytes for one of %zu", size, serialized_bytes());
    Heading heading = heading_of(state);
    memcpy(bytes, &heading, sizeof heading);
    memcpy(bytes + sizeof heading, state, state_bytes());
    return OK;
}

Status state_read(Instance *instance, const char *bytes, size_t size, State **state) {
    if (!state)
        return ERROR;
    if (!bytes || size != serialized_bytes())
        return report(instance, ERROR, "these %zu bytes are no state of this FMU, which takes %zu", size, serialized_bytes());
    State *read = malloc(state_bytes());
    if (!read)
        return report(instance, ERROR, "no memory for a state of %zu bytes", state_bytes());
    memcpy(read, bytes + sizeof(Heading), state_bytes());
    Heading heading = heading_of(read);
    if (memcmp(bytes, &heading, sizeof heading) != 0) {
        free(read);
        return report(instance, ERROR, "these bytes are no state of this FMU, or damaged");
    }
    *state = read;
    return OK;
}
