/* Runs the plant under every friction law and prints a hash of the bits that come out; and on lines that begin with
   "measured" what the plant has needed: instructions of a step in the mean and at most, for each law; bytes of its memory and of
   its stack inside that; bytes of the stack of C. */
#include <inttypes.h>
#include <stdio.h>

#include "loop.h"
#include "plant.h"

/* The first law: that of a plant with one law has a number of its own. */
#ifndef FIRST_LAW
#define FIRST_LAW 1
#endif

enum { STEPS = 300, DEEPEST = 65536, PATTERN = 0xa5 };

/* Instructions so far, where an emulator carries out a fixed number of them in a tick of the timer. */
#ifdef INSTRUCTIONS_PER_TICK
#define SYSTICK(register) (((volatile uint32_t *)0xE000E010u)[register])
static void start_timer(void) {
    SYSTICK(1) = 0xffffffu;
    SYSTICK(2) = 0;
    SYSTICK(0) = 5;
}
/* The timer counts down, in 24 bits. */
static uint32_t ticks(void) { return 0xffffffu - SYSTICK(2); }
static uint32_t instructions_since(uint32_t begin) { return ((ticks() - begin) & 0xffffffu) * INSTRUCTIONS_PER_TICK; }
#else
static void start_timer(void) {}
static uint32_t ticks(void) { return 0; }
static uint32_t instructions_since(uint32_t begin) { return begin; }
#endif

/* Bytes of the stack of C below this call: all get a pattern, and those that have lost it have been used. From the first to
   the last, since a system may give memory to a stack in that order only. */
static volatile uintptr_t bottom;

static volatile unsigned char *below(int depth) { return (volatile unsigned char *)(bottom - (uintptr_t)depth); }

static void paint(void) {
    volatile unsigned char here = 0;
    int depth;
    bottom = (uintptr_t)&here;
    for (depth = 512; depth < DEEPEST; depth++) *below(depth) = PATTERN;
}

static int painted_depth(void) {
    int depth = DEEPEST - 1;
    while (depth > 512 && *below(depth) == PATTERN) depth--;
    return depth;
}

static uint64_t hash;

static void take(double value) {
    uint64_t bits;
    int byte;
    memcpy(&bits, &value, sizeof bits);
    for (byte = 0; byte < 8; byte++) hash = (hash ^ (bits >> (8 * byte) & 255)) * 0x100000001b3ull;
}

static void show(const char *text) { puts(text); }

/* Steps of 1 ms under a valve voltage that rises and falls by sixteenths, which are exact, and what they took at most. */
static int run(Plant *plant, uint32_t *worst, uint64_t *all) {
    static const unsigned shown[] = {REF_position, REF_velocity, REF_acceleration, REF_chamberA_pressure, REF_chamberB_pressure};
    int step, problem = 0;
    size_t place;
    for (step = 0; step < STEPS && !problem; step++) {
        int phase = step % 150;
        double value = 0.0;
        uint32_t begin = ticks(), took;
        problem = plant_set(plant, REF_valveVoltage, 0.0625 * (phase < 75 ? 130 - phase : phase - 20));
        if (!problem) problem = plant_step(plant, 1e-3);
        took = instructions_since(begin);
        if (took > *worst && step > 0) *worst = took;
        *all += took;
        for (place = 0; place < sizeof shown / sizeof *shown && !problem; place++) {
            problem = plant_get(plant, shown[place], &value);
            take(value);
        }
    }
    return problem;
}

/* The memory of the module that is not 0: its stack, which grows from where its pointer g0 rests down to the beginning, and
   its end. */
static void measure(const Plant *plant, uint32_t *stack, uint32_t *end) {
    uint32_t low = 0, high = MEMORY;
    while (low < plant->module.g0 && plant->module.memory[low] == 0) low++;
    while (high > 0 && plant->module.memory[high - 1] == 0) high--;
    if (plant->module.g0 - low > *stack) *stack = plant->module.g0 - low;
    if (high > *end) *end = high;
}

int main(void) {
    int law, problem = 0;
    uint32_t stack = 0, end = 0;
    paint();
    start_timer();
    for (law = FIRST_LAW; law < FIRST_LAW + LAWS && !problem; law++) {
        uint32_t worst = 0;
        uint64_t all = 0;
        Plant *plant = plant_init(show);
        if (!plant) return 1;
        hash = 0xcbf29ce484222325ull;
        problem = plant_choose(plant, REF_friction_law, law);
        if (!problem) problem = run(plant, &worst, &all);
        printf("law %d %08" PRIx32 "%08" PRIx32 "\n", law, (uint32_t)(hash >> 32), (uint32_t)hash);
        if (worst) printf("measured instructions %" PRIu32 " %" PRIu32 "\n", (uint32_t)(all / STEPS), worst);
        measure(plant, &stack, &end);
        plant_free(plant);
    }
    printf("measured memory %" PRIu32 " %" PRIu32 "\nmeasured stack %d\n", end, stack, painted_depth());
    return problem;
}
