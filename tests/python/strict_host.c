/* A host that measures each call: the stack that it takes, and the floating-point exceptions that it raises.

     strict_host LIBRARY VERSION KIND MODE TOKEN SETTING...

   VERSION is 2 or 3; KIND is steps, events or exchange; MODE is flags, or traps, which ends the process where a call is invalid,
   divides by zero or overflows. Settings are
     i:REFERENCE:VALUE, e:..., r:..., b:...                              a parameter: integer (enumeration in FMI 2.0), enumeration, real, boolean
     u:REFERENCE:MEAN:AMPLITUDE:FREQUENCY                                a sine that an input follows
     y:REFERENCE                                                         an output that is read and differentiated
     steps:NUMBER:SIZE                                                   the communication steps
   Prints a line for each function: its name, the most bytes of stack, and the exceptions (1 invalid, 2 division by zero, 4
   overflow). Each call has a thread of its own, whose stack is painted before. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <fenv.h>
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { STACK = 1 << 18, PAINT = 0xa5, MOST = 64, VALUES = 1024 };

typedef struct { char type; uint32_t reference; double value, amplitude, frequency; } Setting;
typedef struct { const char *name; size_t stack; int flags; } Seen;

static Setting settings[MOST];
static Seen seen[MOST];
static int setting_count, seen_count, steps = 1, version;
static double size = 1e-3, now;
static bool traps;
static uint64_t *stack;
static void *library;

/* Of what the call that is measured works on. */
static void *instance, *state, *copy;
static const char *token, *kind;
static char *bytes;
static size_t length, states, indicators;
static double x[VALUES], rate[VALUES], indicator[VALUES];
static int answers[16];

#define F(name, result, ...) ((result (*)(__VA_ARGS__))find(name))
static void *find(const char *name) {
    void *function = dlsym(library, name);
    if (!function) { fprintf(stderr, "no %s\n", name); exit(2); }
    return function;
}
static bool is(const char *other) { return !strcmp(kind, other); }

static int nothing(void) { return 0; }

static int instantiate(void) {
    if (version == 2) {
        instance = F("fmi2Instantiate", void *, const char *, int, const char *, const char *, const void *, int, int)
            ("strict", is("exchange") ? 0 : 1, token, NULL, NULL, 0, 0);
    } else if (is("exchange")) {
        instance = F("fmi3InstantiateModelExchange", void *, const char *, const char *, const char *, bool, bool, void *, void *)
            ("strict", token, NULL, false, false, NULL, NULL);
    } else {
        bool events = is("events");
        instance = F("fmi3InstantiateCoSimulation", void *, const char *, const char *, const char *, bool, bool, bool, bool,
                     const uint32_t *, size_t, void *, void *, void *)
            ("strict", token, NULL, false, false, events, events, NULL, 0, NULL, NULL, NULL);
    }
    return !instance;
}

static int set_one(const Setting *it, double value) {
    int integer = (int)value;
    int64_t item = (int64_t)value;
    bool flag = value != 0;
    uint32_t r = it->reference;
    if (version == 2) switch (it->type) {
        case 'i': return F("fmi2SetInteger", int, void *, const uint32_t *, size_t, const int *)(instance, &r, 1, &integer);
        case 'b': return F("fmi2SetBoolean", int, void *, const uint32_t *, size_t, const int *)(instance, &r, 1, &integer);
        default: return F("fmi2SetReal", int, void *, const uint32_t *, size_t, const double *)(instance, &r, 1, &value);
    }
    switch (it->type) {
        case 'i': return F("fmi3SetInt32", int, void *, const uint32_t *, size_t, const int *, size_t)(instance, &r, 1, &integer, 1);
        case 'e': return F("fmi3SetInt64", int, void *, const uint32_t *, size_t, const int64_t *, size_t)(instance, &r, 1, &item, 1);
        case 'b': return F("fmi3SetBoolean", int, void *, const uint32_t *, size_t, const bool *, size_t)(instance, &r, 1, &flag, 1);
        default: return F("fmi3SetFloat64", int, void *, const uint32_t *, size_t, const double *, size_t)(instance, &r, 1, &value, 1);
    }
}
static int set_parameters(void) {
    int worst = 0;
    for (int i = 0; i < setting_count; i++)
        if (strchr("ierb", settings[i].type)) worst |= set_one(&settings[i], settings[i].value);
    return worst;
}
static int set_inputs(void) {
    int worst = 0;
    for (int i = 0; i < setting_count; i++)
        if (settings[i].type == 'u')
            worst |= set_one(&settings[i], settings[i].value + settings[i].amplitude * sin(2 * M_PI * settings[i].frequency * now));
    return worst;
}
static int get_outputs(void) {
    int worst = 0;
    for (int i = 0; i < setting_count; i++) {
        double value;
        uint32_t r = settings[i].reference;
        if (settings[i].type != 'y') continue;
        worst |= version == 2
            ? F("fmi2GetReal", int, void *, const uint32_t *, size_t, double *)(instance, &r, 1, &value)
            : F("fmi3GetFloat64", int, void *, const uint32_t *, size_t, double *, size_t)(instance, &r, 1, &value, 1);
    }
    return worst;
}
static int differentiate(void) {
    int worst = 0;
    double seed = 1, slope;
    for (int i = 0; i < setting_count; i++) for (int j = 0; j < setting_count; j++) {
        uint32_t y = settings[i].reference, u = settings[j].reference;
        if (settings[i].type != 'y' || settings[j].type != 'u') continue;
        if (version == 2) {
            worst |= F("fmi2GetDirectionalDerivative", int, void *, const uint32_t *, size_t, const uint32_t *, size_t,
                       const double *, double *)(instance, &y, 1, &u, 1, &seed, &slope);
        } else {
            worst |= F("fmi3GetDirectionalDerivative", int, void *, const uint32_t *, size_t, const uint32_t *, size_t,
                       const double *, size_t, double *, size_t)(instance, &y, 1, &u, 1, &seed, 1, &slope, 1);
            worst |= F("fmi3GetAdjointDerivative", int, void *, const uint32_t *, size_t, const uint32_t *, size_t,
                       const double *, size_t, double *, size_t)(instance, &y, 1, &u, 1, &seed, 1, &slope, 1);
        }
    }
    return worst;
}

static int enter(void) {
    if (version == 3)
        return F("fmi3EnterInitializationMode", int, void *, bool, double, double, bool, double)(instance, false, 0, 0, false, 0);
    return F("fmi2SetupExperiment", int, void *, int, double, double, int, double)(instance, 0, 0, 0, 0, 0)
        || F("fmi2EnterInitializationMode", int, void *)(instance);
}
/* A function that takes the instance only. */
static int plain(const char *two, const char *three) { return F(version == 2 ? two : three, int, void *)(instance); }
static int leave(void) { return plain("fmi2ExitInitializationMode", "fmi3ExitInitializationMode"); }
static int enter_events(void) { return plain("fmi2EnterEventMode", "fmi3EnterEventMode"); }
static int leave_events(void) {
    return is("events") ? plain("", "fmi3EnterStepMode") : plain("fmi2EnterContinuousTimeMode", "fmi3EnterContinuousTimeMode");
}
static int terminate(void) { return plain("fmi2Terminate", "fmi3Terminate"); }
static int reset(void) { return plain("fmi2Reset", "fmi3Reset"); }
static int free_instance(void) {
    F(version == 2 ? "fmi2FreeInstance" : "fmi3FreeInstance", void, void *)(instance);
    return 0;
}
static int update(void) {
    bool flags[5];
    double next;
    if (version == 2) return F("fmi2NewDiscreteStates", int, void *, void *)(instance, answers);
    return F("fmi3UpdateDiscreteStates", int, void *, bool *, bool *, bool *, bool *, bool *, double *)
        (instance, flags, flags + 1, flags + 2, flags + 3, flags + 4, &next);
}
static int step(void) {
    bool flags[4];
    double last;
    int status = version == 2
        ? F("fmi2DoStep", int, void *, double, double, int)(instance, now, size, 1)
        : F("fmi3DoStep", int, void *, double, double, bool, bool *, bool *, bool *, double *)
            (instance, now, size, true, flags, flags + 1, flags + 2, &last);
    answers[0] = version == 3 && flags[0];
    now = version == 3 && flags[2] ? last : now + size;
    return status;
}

static int vector(const char *two, const char *three, double *values, size_t number) {
    return F(version == 2 ? two : three, int, void *, double *, size_t)(instance, values, number);
}
static int get_states(void) { return vector("fmi2GetContinuousStates", "fmi3GetContinuousStates", x, states); }
static int get_rates(void) { return vector("fmi2GetDerivatives", "fmi3GetContinuousStateDerivatives", rate, states); }
static int get_indicators(void) { return vector("fmi2GetEventIndicators", "fmi3GetEventIndicators", indicator, indicators); }
static int get_nominals(void) {
    double nominal[VALUES];
    return vector("fmi2GetNominalsOfContinuousStates", "fmi3GetNominalsOfContinuousStates", nominal, states);
}
static int set_states(void) {
    return F(version == 2 ? "fmi2SetContinuousStates" : "fmi3SetContinuousStates", int, void *, const double *, size_t)
        (instance, x, states);
}
static int set_time(void) { return F(version == 2 ? "fmi2SetTime" : "fmi3SetTime", int, void *, double)(instance, now); }
static int complete(void) {
    bool flags[2];
    return version == 2
        ? F("fmi2CompletedIntegratorStep", int, void *, int, int *, int *)(instance, 1, answers, answers + 1)
        : F("fmi3CompletedIntegratorStep", int, void *, bool, bool *, bool *)(instance, true, flags, flags + 1);
}

static int save(void) { return F(version == 2 ? "fmi2GetFMUstate" : "fmi3GetFMUState", int, void *, void **)(instance, &state); }
static int restore(void) { return F(version == 2 ? "fmi2SetFMUstate" : "fmi3SetFMUState", int, void *, void *)(instance, state); }
static int restore_copy(void) { return F(version == 2 ? "fmi2SetFMUstate" : "fmi3SetFMUState", int, void *, void *)(instance, copy); }
static int forget(void) { return F(version == 2 ? "fmi2FreeFMUstate" : "fmi3FreeFMUState", int, void *, void **)(instance, &state); }
static int measure(void) {
    return F(version == 2 ? "fmi2SerializedFMUstateSize" : "fmi3SerializedFMUStateSize", int, void *, void *, size_t *)
        (instance, state, &length);
}
static int serialize(void) {
    return F(version == 2 ? "fmi2SerializeFMUstate" : "fmi3SerializeFMUState", int, void *, void *, char *, size_t)
        (instance, state, bytes, length);
}
static int deserialize(void) {
    return F(version == 2 ? "fmi2DeSerializeFMUstate" : "fmi3DeserializeFMUState", int, void *, const char *, size_t, void **)
        (instance, bytes, length, &copy);
}

static int (*work)(void);
static int status, raised;

static void *run(void *unused) {
    if (traps) feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
    feclearexcept(FE_ALL_EXCEPT);
    status = work();
    raised = fetestexcept(FE_INVALID) ? 1 : 0;
    raised |= fetestexcept(FE_DIVBYZERO) ? 2 : 0;
    raised |= fetestexcept(FE_OVERFLOW) ? 4 : 0;
    return unused;
}

static size_t depth(int (*function)(void)) {
    pthread_attr_t attributes;
    pthread_t thread;
    size_t clean = 0;
    uint64_t paint;
    memset(stack, PAINT, STACK);
    memset(&paint, PAINT, sizeof paint);
    work = function;
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, stack, STACK);
    if (pthread_create(&thread, &attributes, run, NULL) || pthread_join(thread, NULL)) { perror("thread"); exit(2); }
    pthread_attr_destroy(&attributes);
    while (clean < STACK / sizeof paint && stack[clean] == paint) clean++;
    return STACK - clean * sizeof paint;
}

/* Carries out a call. A step may stop early: the plant itself may refuse to go on. */
static void call(const char *name, int (*function)(void)) {
    static size_t base;
    int i = 0;
    if (!base) base = depth(nothing);
    size_t taken = depth(function);
    while (i < seen_count && strcmp(seen[i].name, name)) i++;
    if (i == seen_count) seen[seen_count++].name = name;
    if (taken > base && taken - base > seen[i].stack) seen[i].stack = taken - base;
    seen[i].flags |= raised;
    if (status) { fprintf(stderr, "%s returned %d at %g s\n", name, status, now); exit(1); }
}
#define CALL(function) call(#function, function)

int main(int count, char **arguments) {
    stack = mmap(NULL, STACK, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    library = count > 5 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (!library || stack == MAP_FAILED) { fprintf(stderr, "%s\n", count > 5 ? dlerror() : "too few arguments"); return 2; }
    version = atoi(arguments[2]);
    kind = arguments[3];
    traps = !strcmp(arguments[4], "traps");
    token = arguments[5];
    for (int i = 6; i < count; i++) {
        Setting *it = &settings[setting_count];
        if (sscanf(arguments[i], "steps:%d:%lg", &steps, &size) == 2) continue;
        if (sscanf(arguments[i], "states:%zu:%zu", &states, &indicators) == 2) continue;
        if (sscanf(arguments[i], "%c:%u:%lg:%lg:%lg", &it->type, &it->reference, &it->value, &it->amplitude, &it->frequency) < 2
            || ++setting_count == MOST) { fprintf(stderr, "what is %s?\n", arguments[i]); return 2; }
    }

    for (int life = 0; life < 2; life++) {
        if (life == 0) CALL(instantiate);
        CALL(set_parameters);
        CALL(enter);
        CALL(set_inputs);
        CALL(get_outputs);
        CALL(leave);
        bool exchanges = is("exchange");
        if (exchanges || is("events")) { CALL(update); CALL(leave_events); }
        if (exchanges) { CALL(get_states); CALL(get_nominals); }
        for (int i = 0; i < steps; i++) {
            if (is("events") || (exchanges && i % 4 == 0)) {
                CALL(enter_events);
                CALL(set_inputs);
                CALL(update);
                CALL(leave_events);
            } else {
                CALL(set_inputs);
            }
            if (exchanges) {
                CALL(get_states);
                CALL(get_rates);
                for (size_t k = 0; k < states; k++) x[k] += size * rate[k];
                now += size;
                CALL(set_time);
                CALL(set_states);
                CALL(get_indicators);
                CALL(complete);
            } else {
                CALL(step);
            }
            CALL(get_outputs);
            if (i % 16 == 0) CALL(differentiate);
        }
        CALL(save);
        CALL(measure);
        bytes = realloc(bytes, length);
        CALL(serialize);
        CALL(restore);
        CALL(deserialize);
        CALL(restore_copy);
        CALL(forget);
        CALL(get_outputs);
        CALL(terminate);
        CALL(reset);
        now = 0;
    }
    CALL(free_instance);
    for (int i = 0; i < seen_count; i++) printf("%s %zu %d\n", seen[i].name, seen[i].stack, seen[i].flags);
    return 0;
}
