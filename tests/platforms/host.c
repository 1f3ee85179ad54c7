/* A small FMI 2.0 host: runs experiments on a shared library and prints the bits of everything it computes.
 *
 *     host LIBRARY < EXPERIMENTS
 *
 * It has no dependency but the headers of the standard and the C library, so that any cross compiler builds it and any emulator runs it. The inputs come
 * as bits, so that no function of the platform's own C library has a part in the results. */

#ifdef _WIN32
#define __USE_MINGW_ANSI_STDIO 1
#include <windows.h>
#else
#include <dlfcn.h>
#endif
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

typedef fmi2ValueReference Reference;

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

static void fail(const char *what) {
    fprintf(stderr, "host: %s failed\n", what);
    exit(1);
}

#define CALL(call) do { if ((call) != fmi2OK) fail(#call); } while (0)

static void *function(void *library, const char *name) {
#ifdef _WIN32
    void *address = (void *)GetProcAddress(library, name);
#else
    void *address = dlsym(library, name);
#endif
    if (!address) fail(name);
    return address;
}

static void load(const char *file) {
#ifdef _WIN32
    void *library = LoadLibraryA(file);
    if (!library) fprintf(stderr, "host: error %lu\n", GetLastError());
#else
    void *library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (!library) fprintf(stderr, "host: %s\n", dlerror());
#endif
    if (!library) fail("loading the library");
#define LOAD(member, name) *(void **)&fmi.member = function(library, "fmi2" name)
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

/* What is read from the standard input. */
static char guid[64];
static size_t steps, input_count, output_count;
static double step;
static Reference *inputs, *outputs;
static double *samples;

static uint64_t read_number(const char *format) {
    uint64_t number;
    if (scanf(format, &number) != 1) fail("reading a number");
    return number;
}

static uint64_t whole(void) { return read_number("%" SCNu64); }

static double real(void) {
    uint64_t bits = read_number("%" SCNx64);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void *array(size_t count, size_t size) {
    void *memory = calloc(count + 1, size);
    if (!memory) fail("allocating memory");
    return memory;
}

static Reference *references(size_t *count) {
    *count = whole();
    Reference *list = array(*count, sizeof *list);
    for (size_t i = 0; i < *count; i++) list[i] = (Reference)whole();
    return list;
}

static void read_experiment(void) {
    if (scanf("%63s", guid) != 1) fail("reading a GUID");
    steps = whole();
    step = real();
    inputs = references(&input_count);
    samples = array(steps * input_count, sizeof *samples);
    for (size_t i = 0; i < steps * input_count; i++) samples[i] = real();
    outputs = references(&output_count);
}

/* Takes a step and leaves the outputs at its end. */
static void advance(fmi2Component instance, size_t index, double *values) {
    CALL(fmi.set_real(instance, inputs, input_count, samples + index * input_count));
    CALL(fmi.do_step(instance, (double)index * step, step, fmi2True));
    CALL(fmi.get_real(instance, outputs, output_count, values));
}

enum { AHEAD = 20 };

/* Goes some steps ahead and back by a saved state, again by a state that was bytes meanwhile, and must see the same. */
static void rehearse(fmi2Component instance, size_t index) {
    size_t row = output_count, size = 0;
    double *first = array(AHEAD * row, sizeof *first), *again = array(AHEAD * row, sizeof *again);
    fmi2FMUstate state = NULL, copy = NULL;
    CALL(fmi.get_state(instance, &state));
    CALL(fmi.serialized_size(instance, state, &size));
    char *bytes = array(size, 1);
    CALL(fmi.serialize(instance, state, bytes, size));
    for (size_t i = 0; i < AHEAD; i++) advance(instance, index + i, first + i * row);
    CALL(fmi.set_state(instance, state));
    CALL(fmi.free_state(instance, &state));
    for (size_t i = 0; i < AHEAD; i++) advance(instance, index + i, again + i * row);
    if (memcmp(first, again, AHEAD * row * sizeof *first)) fail("repeating steps from a saved state");
    CALL(fmi.deserialize(instance, bytes, size, &copy));
    CALL(fmi.set_state(instance, copy));
    CALL(fmi.free_state(instance, &copy));
    printf("state");
    for (size_t i = 0; i < size; i++) printf("%s%02x", i % 32 ? "" : " ", (unsigned char)bytes[i]);
    printf("\n");
    free(bytes), free(first), free(again);
}

static void run(const char *label) {
    fmi2Component instance = fmi.instantiate(label, fmi2CoSimulation, guid, "", &callbacks, fmi2False, fmi2False);
    if (!instance) fail("fmi2Instantiate");
    size_t changes = whole();
    for (size_t i = 0; i < changes; i++) {
        Reference reference = (Reference)whole();
        int value = (int)whole();
        CALL(fmi.set_integer(instance, &reference, 1, &value));
    }
    size_t reals = whole();
    for (size_t i = 0; i < reals; i++) {
        Reference reference = (Reference)whole();
        double value = real();
        CALL(fmi.set_real(instance, &reference, 1, &value));
    }
    CALL(fmi.setup(instance, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    CALL(fmi.enter_initialization(instance));
    CALL(fmi.exit_initialization(instance));
    printf("run %s\n", label);
    double *values = array(output_count, sizeof *values);
    for (size_t index = 0; index < steps; index++) {
        if (index == steps / 2) rehearse(instance, index);
        advance(instance, index, values);
        for (size_t i = 0; i < output_count; i++) {
            uint64_t bits;
            memcpy(&bits, &values[i], sizeof bits);
            printf("%016" PRIx64 "%s", bits, i + 1 < output_count ? " " : "\n");
        }
    }
    free(values);
    CALL(fmi.terminate(instance));
    fmi.free_instance(instance);
}

int main(int count, char **arguments) {
    if (count != 2) fail("host LIBRARY < EXPERIMENTS");
    load(arguments[1]);
    char word[64];
    while (scanf("%63s", word) == 1) {
        if (!strcmp(word, "experiment")) read_experiment();
        else if (!strcmp(word, "run") && scanf("%63s", word) == 1) run(word);
        else fail(word);
    }
    printf("done\n");
    return 0;
}
