/* A small FMI host: runs experiments on a shared library and prints the bits of everything it computes.
 *
 *     host LIBRARY < EXPERIMENTS
 *
 * It has no dependency but the headers of the standard and the C library, so that any cross compiler builds it and any
 * emulator runs it. The inputs come as bits, so that no function of the platform's own C library has a part in the
 * results. */

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

#include "host.h"

static const struct face *const faces[] = {&fmi2, &fmi3, &fmi3_events, &fmi3_exchange};
enum { FACES = sizeof faces / sizeof *faces };

void fail(const char *what) {
    fprintf(stderr, "host: %s failed\n", what);
    exit(1);
}

void *array(size_t count, size_t size) {
    void *memory = calloc(count + 1, size);
    if (!memory) fail("allocating memory");
    return memory;
}

static void *library;

void *function(const char *name) {
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
    library = LoadLibraryA(file);
    if (!library) fprintf(stderr, "host: error %lu\n", GetLastError());
#else
    library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (!library) fprintf(stderr, "host: %s\n", dlerror());
#endif
    if (!library) fail("loading the library");
    for (size_t i = 0; i < FACES; i++) faces[i]->load();
}

/* What is read from the standard input. */
static char token[64];
static size_t samples_count, input_count, output_count;
static double step;
static uint32_t *inputs, *outputs;
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

static uint32_t *references(size_t *count) {
    *count = whole();
    uint32_t *list = array(*count, sizeof *list);
    for (size_t i = 0; i < *count; i++) list[i] = (uint32_t)whole();
    return list;
}

static void read_experiment(void) {
    if (scanf("%63s", token) != 1) fail("reading a token");
    samples_count = whole();
    step = real();
    inputs = references(&input_count);
    samples = array(samples_count * input_count, sizeof *samples);
    for (size_t i = 0; i < samples_count * input_count; i++) samples[i] = real();
    outputs = references(&output_count);
}

static const struct face *read_face(void) {
    char name[16];
    if (scanf("%15s", name) != 1) fail("reading a face");
    for (size_t i = 0; i < FACES; i++) if (!strcmp(name, faces[i]->name)) return faces[i];
    fail(name);
    return NULL;
}

/* Takes a step and leaves what there is at its end. */
static void advance(const struct face *face, size_t index, double *values) {
    face->set(inputs, input_count, samples + index * input_count);
    face->step((double)index * step, step);
    face->get(outputs, output_count, values);
}

enum { AHEAD = 20 };

/* Goes some steps ahead and back by a saved state, again by a state that was bytes meanwhile, and must see the same. */
static void rehearse(const struct face *face, size_t index, size_t width) {
    double *first = array(AHEAD * width, sizeof *first), *again = array(AHEAD * width, sizeof *again);
    void *state = face->save();
    size_t size = face->serialized_size(state);
    unsigned char *bytes = array(size, 1);
    face->serialize(state, bytes, size);
    for (size_t i = 0; i < AHEAD; i++) advance(face, index + i, first + i * width);
    face->restore(state);
    face->forget(state);
    for (size_t i = 0; i < AHEAD; i++) advance(face, index + i, again + i * width);
    if (memcmp(first, again, AHEAD * width * sizeof *first)) fail("repeating steps from a saved state");
    void *copy = face->deserialize(bytes, size);
    face->restore(copy);
    face->forget(copy);
    printf("state");
    for (size_t i = 0; i < size; i++) printf("%s%02x", i % 32 ? "" : " ", bytes[i]);
    printf("\n");
    free(bytes), free(first), free(again);
}

/* The bits of numbers, as `printf` would write them in ten times the time. */
static void print(const double *values, size_t count) {
    char text[17];
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        for (int digit = 15; digit >= 0; digit--, bits >>= 4) text[digit] = "0123456789abcdef"[bits & 15];
        text[16] = i + 1 < count ? ' ' : '\n';
        fwrite(text, 1, sizeof text, stdout);
    }
}

static void run(void) {
    const struct face *face = read_face();
    char label[64];
    if (scanf("%63s", label) != 1) fail("reading a label");
    size_t steps = whole();
    if (steps > samples_count) fail("finding as many inputs as steps");
    face->instantiate(label, token);
    size_t choices = whole();
    for (size_t i = 0; i < choices; i++) {
        uint32_t reference = (uint32_t)whole();
        face->choose(reference, (int)whole());
    }
    size_t reals = whole();
    for (size_t i = 0; i < reals; i++) {
        uint32_t reference = (uint32_t)whole();
        double value = real();
        face->set(&reference, 1, &value);
    }
    face->initialize();
    printf("run %s %s\n", face->name, label);
    size_t width = face->width(output_count);
    double *values = array(width, sizeof *values);
    for (size_t index = 0; index < steps; index++) {
        if (index == steps / 2) rehearse(face, index, width);
        advance(face, index, values);
        print(values, width);
    }
    free(values);
    face->finish();
}

int main(int count, char **arguments) {
    if (count != 2) fail("host LIBRARY < EXPERIMENTS");
    load(arguments[1]);
    char word[64];
    while (scanf("%63s", word) == 1) {
        if (!strcmp(word, "experiment")) read_experiment();
        else if (!strcmp(word, "run")) run();
        else fail(word);
    }
    printf("done\n");
    return 0;
}
