/* Prints how long a communication step of 1 ms takes under every friction law, in ns: of a library of FMI 2.0.

       speed LIBRARY GUID */
#define _POSIX_C_SOURCE 199309L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2FunctionTypes.h"
#include "model.h"

enum { STEPS = 3000, ROUNDS = 3 };

static void *library;

static void *function(const char *name) {
    void *address = dlsym(library, name);
    if (!address) fprintf(stderr, "speed: %s is missing\n", name), exit(1);
    return address;
}

static void check(fmi2Status status) {
    if (status != fmi2OK) fprintf(stderr, "speed: a call ended with status %d\n", status), exit(1);
}

static void silent(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String text, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)text;
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (double)time.tv_sec * 1e9 + (double)time.tv_nsec;
}

static double of_law(fmi2Integer law, const char *guid) {
    static const fmi2CallbackFunctions callbacks = {silent, NULL, NULL, NULL, NULL};
    fmi2InstantiateTYPE *instantiate = (fmi2InstantiateTYPE *)function("fmi2Instantiate");
    fmi2DoStepTYPE *advance = (fmi2DoStepTYPE *)function("fmi2DoStep");
    fmi2SetRealTYPE *set = (fmi2SetRealTYPE *)function("fmi2SetReal");
    fmi2Component plant = instantiate("plant", fmi2CoSimulation, guid, NULL, &callbacks, fmi2False, fmi2False);
    fmi2ValueReference choice = REF_friction_law, input = REF_valveVoltage;
    double begin;
    int step;
    if (!plant) fprintf(stderr, "speed: there is no instance\n"), exit(1);
    check(((fmi2SetIntegerTYPE *)function("fmi2SetInteger"))(plant, &choice, 1, &law));
    check(((fmi2SetupExperimentTYPE *)function("fmi2SetupExperiment"))(plant, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    check(((fmi2EnterInitializationModeTYPE *)function("fmi2EnterInitializationMode"))(plant));
    check(((fmi2ExitInitializationModeTYPE *)function("fmi2ExitInitializationMode"))(plant));
    begin = now();
    for (step = 0; step < STEPS; step++) {
        int phase = step % 150;
        double voltage = 0.0625 * (phase < 75 ? 130 - phase : phase - 20);
        check(set(plant, &input, 1, &voltage));
        check(advance(plant, 1e-3 * step, 1e-3, fmi2True));
    }
    begin = (now() - begin) / STEPS;
    ((fmi2FreeInstanceTYPE *)function("fmi2FreeInstance"))(plant);
    return begin;
}

int main(int count, char *arguments[]) {
    int law, round;
    if (count != 3) return 2;
    library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) return fprintf(stderr, "speed: %s\n", dlerror()), 1;
    for (law = 1; law <= LAWS; law++) {
        double least = 0.0;
        for (round = 0; round < ROUNDS; round++) {
            double took = of_law(law, arguments[2]);
            if (round == 0 || took < least) least = took;
        }
        printf("%d %.0f\n", law, least);
    }
    return 0;
}
