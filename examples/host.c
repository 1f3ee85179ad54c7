/* Runs the cylinder in real time: a position loop of 1 kHz, with histograms of how late it woke up and how long it took.
 *
 *     unzip -d plant target/fmu/PneumaticServoCylinder.fmu
 *     gcc -O2 -I HEADERS -o host examples/host.c -ldl && ./host plant 10
 *
 * HEADERS is a folder with the headers of the standard, for example fmpy/c-code where FMPy is installed.
 * As root, or with the limits `rtprio` and `memlock`, it runs under SCHED_FIFO with its memory locked. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

enum { PERIOD = 1000000, BUCKETS = 16 }; /* ns; of 1, 2, 4, ... us */
typedef struct { uint64_t counts[BUCKETS]; int64_t largest; double sum; } Histogram;

static void fail(const char *what) {
    fprintf(stderr, "host: %s failed\n", what);
    exit(1);
}
#define CALL(call) do { if ((call) != fmi2OK) fail(#call); } while (0)

static void usage(const char *problem) {
    fprintf(stderr, "host: %s\nusage: host FOLDER [SECONDS]\n", problem);
    exit(2);
}

/* How many steps a text of seconds is long. */
static uint64_t steps_of(const char *seconds) {
    char *end;
    double duration = strtod(seconds, &end);
    double steps = 1e9 * duration / PERIOD;
    if (end == seconds || *end || !(steps >= 1.0 && steps < 1e12)) {
        char problem[256];
        snprintf(problem, sizeof problem, "SECONDS is %.100s; it must be a number from 0.001 to 1e9", seconds);
        usage(problem);
    }
    return (uint64_t)(steps + 0.5);
}

static int64_t now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * INT64_C(1000000000) + time.tv_nsec;
}

static void count(Histogram *histogram, int64_t time) {
    int bucket = 0;
    while (bucket < BUCKETS - 1 && time >= INT64_C(1000) << bucket) bucket++;
    histogram->counts[bucket]++;
    histogram->sum += (double)time;
    if (time > histogram->largest) histogram->largest = time;
}

static void print(const char *title, const Histogram *histogram, uint64_t steps) {
    printf("%s: mean %.1f us, largest %.1f us\n", title, 1e-3 * histogram->sum / (double)steps, 1e-3 * (double)histogram->largest);
    for (int i = 0; i < BUCKETS; i++)
        if (histogram->counts[i])
            printf("  %s %6d us: %llu\n", i < BUCKETS - 1 ? "below" : "from ", 1 << (i < BUCKETS - 1 ? i : i - 1),
                   (unsigned long long)histogram->counts[i]);
}

/* The text between a mark in the model description and the next quotation mark. */
static const char *attribute(const char *xml, const char *mark) {
    const char *begin = strstr(xml, mark);
    if (!begin) fail(mark);
    begin += strlen(mark);
    return strndup(begin, strcspn(begin, "\""));
}

static fmi2ValueReference reference(const char *xml, const char *name) {
    char mark[128];
    snprintf(mark, sizeof mark, "name=\"%s\" valueReference=\"", name);
    return (fmi2ValueReference)strtoul(attribute(xml, mark), NULL, 10);
}

int main(int arguments, char **argument) {
    if (arguments < 2 || arguments > 3) usage("it takes a folder and, if not 10 s are meant, a number of seconds");
    uint64_t steps = steps_of(arguments > 2 ? argument[2] : "10");
    static char path[4096], xml[1 << 20];
    snprintf(path, sizeof path, "%s/modelDescription.xml", argument[1]);
    FILE *file = fopen(path, "r");
    if (!file || !fread(xml, 1, sizeof xml - 1, file)) fail(path);
    fclose(file);
    snprintf(path, sizeof path, "%s/binaries/linux64/%s.so", argument[1], attribute(xml, "modelIdentifier=\""));
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fail(dlerror());

#define FUNCTION(name) fmi2##name##TYPE *name = dlsym(library, "fmi2" #name); if (!name) fail("fmi2" #name)
    FUNCTION(Instantiate);
    FUNCTION(SetupExperiment);
    FUNCTION(EnterInitializationMode);
    FUNCTION(ExitInitializationMode);
    FUNCTION(SetReal);
    FUNCTION(GetReal);
    FUNCTION(DoStep);
    FUNCTION(FreeInstance);

    /* A set of callbacks is allowed to be absent, and nothing is logged. */
    fmi2Component plant = Instantiate("plant", fmi2CoSimulation, attribute(xml, "guid=\""), "", NULL, fmi2False, fmi2False);
    if (!plant) fail("fmi2Instantiate");
    CALL(SetupExperiment(plant, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    CALL(EnterInitializationMode(plant));
    CALL(ExitInitializationMode(plant));
    const fmi2ValueReference voltage = reference(xml, "valveVoltage"), position = reference(xml, "position");

    int fifo = sched_setscheduler(0, SCHED_FIFO, &(struct sched_param){.sched_priority = 80});
    printf("scheduler: %s\n", fifo == 0 ? "SCHED_FIFO, priority 80" : strerror(errno));
    int locked = mlockall(MCL_CURRENT | MCL_FUTURE);
    printf("memory: %s\n", locked == 0 ? "locked" : strerror(errno));

    Histogram late = {0}, busy = {0};
    int64_t due = now();
    double x = 0.0;
    CALL(GetReal(plant, &position, 1, &x));
    for (uint64_t k = 0; k < steps; k++) {
        due += PERIOD;
        struct timespec wake = {due / 1000000000, due % 1000000000};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, NULL) == EINTR) {}
        int64_t begin = now();
        double u = 5.0 + 40.0 * (0.3 - x); /* towards 0.3 m */
        CALL(SetReal(plant, &voltage, 1, &u));
        CALL(DoStep(plant, 1e-3 * (double)k, 1e-3, fmi2True));
        CALL(GetReal(plant, &position, 1, &x));
        count(&busy, now() - begin);
        count(&late, begin - due);
    }
    printf("steps: %llu\nposition: %.17g\n", (unsigned long long)steps, x);
    print("late", &late, steps);
    print("busy", &busy, steps);
    FreeInstance(plant);
    return 0;
}
