/* A program without Python that loads an FMI 2 FMU's library and steps it; prints every output as its bits.

   Arguments: library, guid, number of outputs, their first value reference, number of steps, step [s], and then
   value references of inputs with their values. */

#include <dlfcn.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 4096 };

typedef void *Instantiate(const char *, int, const char *, const char *, const void *, int, int);
typedef int Call(void *);
typedef int Setup(void *, int, double, double, int, double);
typedef int Set(void *, const unsigned *, size_t, const double *);
typedef int Get(void *, const unsigned *, size_t, double *);
typedef int Step(void *, double, double, int);
typedef void Free(void *);

static void *library;

static void *function(const char *name) {
    void *found = dlsym(library, name);
    if (!found)
        exit(2);
    return found;
}

static void print(Get *get, void *c, unsigned first, size_t n) {
    static unsigned references[MOST];
    static double values[MOST];
    for (size_t i = 0; i < n; i++)
        references[i] = first + (unsigned)i;
    if (get(c, references, n, values) != 0)
        exit(3);
    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        printf("%016" PRIx64 "%c", bits, i + 1 < n ? ' ' : '\n');
    }
}

int main(int argc, char **argv) {
    size_t n = strtoul(argv[3], NULL, 10);
    unsigned first = (unsigned)strtoul(argv[4], NULL, 10);
    long steps = strtol(argv[5], NULL, 10);
    double h = strtod(argv[6], NULL);
    library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (!library || n > MOST)
        return 1;
    /* A null pointer for the callbacks: there is nobody to log to. */
    void *c = ((Instantiate *)function("fmi2Instantiate"))("program", 1, argv[2], "", NULL, 0, 0);
    if (!c || ((Setup *)function("fmi2SetupExperiment"))(c, 0, 0.0, 0.0, 0, 0.0) != 0)
        return 4;
    ((Call *)function("fmi2EnterInitializationMode"))(c);
    for (int i = 7; i + 1 < argc; i += 2) {
        unsigned reference = (unsigned)strtoul(argv[i], NULL, 10);
        double value = strtod(argv[i + 1], NULL);
        if (((Set *)function("fmi2SetReal"))(c, &reference, 1, &value) != 0)
            return 5;
    }
    if (((Call *)function("fmi2ExitInitializationMode"))(c) != 0)
        return 6;
    Get *get = (Get *)function("fmi2GetReal");
    print(get, c, first, n);
    for (long k = 0; k < steps; k++) {
        if (((Step *)function("fmi2DoStep"))(c, (double)k * h, h, 1) != 0)
            return 7;
        print(get, c, first, n);
    }
    ((Free *)function("fmi2FreeInstance"))(c);
    return 0;
}
