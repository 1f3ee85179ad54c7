/* The plant in a control loop on a target without an operating system: three functions, no FMI.

   Unpack the folder `sources` of PneumaticServoCylinder.fmu (FMI 2.0, made by `cargo xtask package --sources`), then

       cc -std=c99 -O2 -I sources main.c sources/plant.c sources/operators.c sources/loop.c sources/code*.c -lm

   docs/target.md says how to build for a microcontroller. A proportional controller moves the carriage to 0.3 m; the last
   lines are the bits of the results, which are the same on every target. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "loop.h"

static void show(const char *text) { puts(text); }

/* A number and its bits. */
static void print(const char *name, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    printf("%s %.6g %08" PRIx32 "%08" PRIx32 "\n", name, value, (uint32_t)(bits >> 32), (uint32_t)bits);
}

int main(void) {
    int step, problem;
    double position = 0.0, velocity = 0.0;
    Plant *plant = plant_init(show);
    if (!plant) return 1;
    problem = plant_choose(plant, REF_friction_law, 14); /* LuGre */
    for (step = 0; step < 3000 && !problem; step++) {
        double voltage = 5.0 + 20.0 * (0.3 - position);
        if (voltage > 10.0) voltage = 10.0;
        if (voltage < 0.0) voltage = 0.0;
        problem = plant_set(plant, REF_valveVoltage, voltage);
        if (!problem) problem = plant_step(plant, 1e-3);
        if (!problem) problem = plant_get(plant, REF_position, &position);
    }
    if (!problem) problem = plant_get(plant, REF_velocity, &velocity);
    print("position", position);
    print("velocity", velocity);
    plant_free(plant);
    return problem;
}
