/* The plant in a control loop: without FMI, in SI units. Variables are named in model.h, where REF_valveVoltage is the value
   reference of valveVoltage. Each function tells how it ended: 0 is well, and what was refused goes to the log. */
#ifndef LOOP_H
#define LOOP_H

#include "model.h"

#define plant_init PLANT_NAME(plant_init)
#define plant_set PLANT_NAME(plant_set)
#define plant_choose PLANT_NAME(plant_choose)
#define plant_step PLANT_NAME(plant_step)
#define plant_get PLANT_NAME(plant_get)
#define plant_free PLANT_NAME(plant_free)

typedef struct Plant Plant;

/* Takes a message. */
typedef void PlantLog(const char *text);

/* A plant with its default parameters at time 0; NULL if there is no memory for one more. The log may be NULL. */
Plant *plant_init(PlantLog *log);
/* Sets an input, or before the first step a parameter. */
int plant_set(Plant *plant, unsigned reference, double value);
/* The same for an enumeration or an integer. */
int plant_choose(Plant *plant, unsigned reference, int value);
/* Goes on by a step in s; the first starts the run. */
int plant_step(Plant *plant, double step);
/* Reads a variable, from the first step on. */
int plant_get(Plant *plant, unsigned reference, double *value);
/* Frees the plant; NULL is fine. */
void plant_free(Plant *plant);

#endif
