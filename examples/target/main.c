/** @file main.c
 *  @brief The plant in a control loop on a target without an operating system: no FMI.
 *
 *  Unpack the folder `sources` of PneumaticServoCylinder.fmu, made by `cargo xtask package --sources`, then
 *
 *      cc -std=c99 -O2 -I sources main.c sources/plant.c sources/arrays.c sources/operators.c sources/loop.c \
 *         sources/model.c sources/code*.c -lm
 *
 *  docs/target.md says how to build for a microcontroller. A proportional controller moves the carriage to 0.3 m; the last lines
 *  are the bits of the results, which are the same on every target. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "loop.h"

enum { STEPS = 3000 };

/** The one plant of this program. */
static Plant *plant;

static void show(const char *text) { puts(text); }

/** A number and its bits. */
static void print(const char *name, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    printf("%s %.6g %08" PRIx32 "%08" PRIx32 "\n", name, value, (uint32_t)(bits >> 32), (uint32_t)bits);
}

/** Makes the plant, sets its parameters and begins the run: outputs can be read before the first step. */
static PlantStatus model_initialize(PlantOutputs *outputs) {
    const PlantVariable *law = plant_find("friction.law");
    PlantStatus status = PLANT_ERROR;
    plant = plant_init(show);
    if (plant != NULL) {
        status = PLANT_OK;
        /* 14: LuGre, where all laws are compiled. */
        if (law != NULL && law->max >= 14.0 && law->min <= 14.0) status = plant_choose(plant, law->reference, 14);
        if (status == PLANT_OK) status = plant_start(plant);
        if (status == PLANT_OK) status = plant_read(plant, outputs);
    }
    return status;
}

/** One step of 1 ms. */
static PlantStatus model_step(const PlantInputs *inputs, PlantOutputs *outputs) {
    PlantStatus status = plant_write(plant, inputs);
    if (status == PLANT_OK) status = plant_step(plant, 1e-3);
    if (status == PLANT_OK) status = plant_read(plant, outputs);
    return status;
}

/** Gives the memory of the plant back. */
static void model_terminate(void) {
    plant_free(plant);
    plant = NULL;
}

int main(void) {
    static PlantOutputs outputs;
    PlantInputs inputs = {.valveVoltage = 5.0, .supplyPressure = 5e5}; /* V, Pa */
    PlantStatus status = model_initialize(&outputs);
    int step;
    for (step = 0; step < STEPS && status == PLANT_OK; step++) {
        inputs.valveVoltage = 5.0 + 20.0 * (0.3 - outputs.position);
        if (inputs.valveVoltage > 10.0) inputs.valveVoltage = 10.0;
        if (inputs.valveVoltage < 0.0) inputs.valveVoltage = 0.0;
        status = model_step(&inputs, &outputs);
    }
    print("position", outputs.position);
    print("velocity", outputs.velocity);
    model_terminate();
    return (int)status;
}
