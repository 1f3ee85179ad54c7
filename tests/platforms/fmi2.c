/* Co-simulation by FMI 2.0. */

#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"
#include "host.h"

static struct {
    fmi2InstantiateTYPE *instantiate;
    fmi2FreeInstanceTYPE *free_instance;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter_initialization;
    fmi2ExitInitializationModeTYPE *exit_initialization;
    fmi2TerminateTYPE *terminate;
    fmi2SetRealTYPE *set_real;
    fmi2SetIntegerTYPE *set_integer;
    fmi2GetRealTYPE *get_real;
    fmi2DoStepTYPE *do_step;
    fmi2GetFMUstateTYPE *get_state;
    fmi2SetFMUstateTYPE *set_state;
    fmi2FreeFMUstateTYPE *free_state;
    fmi2SerializedFMUstateSizeTYPE *serialized_size;
    fmi2SerializeFMUstateTYPE *serialize;
    fmi2DeSerializeFMUstateTYPE *deserialize;
} fmi;

static fmi2Component instance;

static void load(void) {
#define LOAD(member, name) *(void **)&fmi.member = function("fmi2" name)
    LOAD(instantiate, "Instantiate");
    LOAD(free_instance, "FreeInstance");
    LOAD(setup, "SetupExperiment");
    LOAD(enter_initialization, "EnterInitializationMode");
    LOAD(exit_initialization, "ExitInitializationMode");
    LOAD(terminate, "Terminate");
    LOAD(set_real, "SetReal");
    LOAD(set_integer, "SetInteger");
    LOAD(get_real, "GetReal");
    LOAD(do_step, "DoStep");
    LOAD(get_state, "GetFMUstate");
    LOAD(set_state, "SetFMUstate");
    LOAD(free_state, "FreeFMUstate");
    LOAD(serialized_size, "SerializedFMUstateSize");
    LOAD(serialize, "SerializeFMUstate");
    LOAD(deserialize, "DeSerializeFMUstate");
}

static void print_message(
    fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    (void)environment, (void)name;
    fprintf(stderr, "host: status %d, %s: %s\n", status, category, text);
}

static const fmi2CallbackFunctions callbacks = {print_message, calloc, free, NULL, NULL};

static void instantiate(const char *name, const char *token) {
    instance = fmi.instantiate(name, fmi2CoSimulation, token, "", &callbacks, fmi2False, fmi2False);
    if (!instance) fail("fmi2Instantiate");
}

static void choose(uint32_t reference, int item) { CALL(fmi.set_integer(instance, &reference, 1, &item)); }

static void set(const uint32_t *references, size_t count, const double *values) {
    CALL(fmi.set_real(instance, references, count, values));
}

static void initialize(void) {
    CALL(fmi.setup(instance, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    CALL(fmi.enter_initialization(instance));
    CALL(fmi.exit_initialization(instance));
}

static void take_step(double time, double size) { CALL(fmi.do_step(instance, time, size, fmi2True)); }

static void get(const uint32_t *references, size_t count, double *values) {
    CALL(fmi.get_real(instance, references, count, values));
}

#include "alike.h"

const struct face fmi2 = {
    "fmi2", load, instantiate, choose, set, initialize, take_step, width, get,
    save, restore, forget, serialized_size, serialize, deserialize, finish};
