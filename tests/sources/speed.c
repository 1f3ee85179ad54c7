/* A number of communication steps of 1 ms of a library of FMI 2.0 under a friction law, for valgrind to count instructions.

       speed LIBRARY GUID LAW STEPS */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"
#include "model.h"

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

static void run(fmi2Integer law, int steps, const char *guid) {
    static const fmi2CallbackFunctions callbacks = {silent, NULL, NULL, NULL, NULL};
    fmi2InstantiateTYPE *instantiate = (fmi2InstantiateTYPE *)function("fmi2Instantiate");
    fmi2DoStepTYPE *advance = (fmi2DoStepTYPE *)function("fmi2DoStep");
    fmi2SetRealTYPE *set = (fmi2SetRealTYPE *)function("fmi2SetReal");
    fmi2Component plant = instantiate("plant", fmi2CoSimulation, guid, NULL, &callbacks, fmi2False, fmi2False);
    fmi2ValueReference choice = REF_friction_law, input = REF_valveVoltage;
    int step;
    if (!plant) fprintf(stderr, "speed: there is no instance\n"), exit(1);
    check(((fmi2SetIntegerTYPE *)function("fmi2SetInteger"))(plant, &choice, 1, &law));
    check(((fmi2SetupExperimentTYPE *)function("fmi2SetupExperiment"))(plant, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    check(((fmi2EnterInitializationModeTYPE *)function("fmi2EnterInitializationMode"))(plant));
    check(((fmi2ExitInitializationModeTYPE *)function("fmi2ExitInitializationMode"))(plant));
    for (step = 0; step < steps; step++) {
        int phase = step % 150;
        double voltage = 0.0625 * (phase < 75 ? 130 - phase : phase - 20);
        check(set(plant, &input, 1, &voltage));
        check(advance(plant, 1e-3 * step, 1e-3, fmi2True));
    }
    ((fmi2FreeInstanceTYPE *)function("fmi2FreeInstance"))(plant);
}

int main(int count, char *arguments[]) {
    if (count != 5) return 2;
    library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) return fprintf(stderr, "speed: %s\n", dlerror()), 1;
    run(atoi(arguments[3]), atoi(arguments[4]), arguments[2]);
    return 0;
}
