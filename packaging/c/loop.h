/** @file loop.h
 *  @brief The plant in a control loop: without FMI, without an operating system, in SI units.
 *
 *  A run is made by plant_init(), may then be given parameters by plant_set() and plant_choose(), begins with plant_start(), goes
 *  on with plant_step(), and ends with plant_free(). Variables are named in model.h: REF_valveVoltage is the value reference of
 *  valveVoltage, and the structures PlantInputs and PlantOutputs have all inputs and outputs.
 *
 *  Every function says by a PlantStatus how it ended. A call that is refused has changed nothing, and says why to the log.
 *  One plant belongs to one thread or interrupt at a time: a call during another one is refused.
 */
#ifndef LOOP_H
#define LOOP_H

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

#define plant_init PLANT_NAME(plant_init)
#define plant_set PLANT_NAME(plant_set)
#define plant_choose PLANT_NAME(plant_choose)
#define plant_start PLANT_NAME(plant_start)
#define plant_step PLANT_NAME(plant_step)
#define plant_get PLANT_NAME(plant_get)
#define plant_write PLANT_NAME(plant_write)
#define plant_read PLANT_NAME(plant_read)
#define plant_find PLANT_NAME(plant_find)
#define plant_time PLANT_NAME(plant_time)
#define plant_free PLANT_NAME(plant_free)
#define plant_variables PLANT_NAME(plant_variables)

/** @brief Status of a call, numbered as in FMI. */
typedef enum {
    PLANT_OK,      /**< All is well. */
    PLANT_WARNING, /**< All is well, but the log has something to say. */
    PLANT_DISCARD, /**< Of FMI alone: the call is not possible now. */
    PLANT_ERROR,   /**< The call was refused and has changed nothing; or a step has ended before its end. */
    PLANT_FATAL    /**< The plant can only be freed. */
} PlantStatus;

/** @brief What a variable is for. */
typedef enum {
    PLANT_TIME,      /**< The time. */
    PLANT_INPUT,     /**< May be set at any time. */
    PLANT_FIXED,     /**< A parameter that may be set before the start. */
    PLANT_TUNABLE,   /**< A parameter that may be set at any time. */
    PLANT_OUTPUT,    /**< Is computed, and meant to be connected or watched. */
    PLANT_LOCAL      /**< Is computed, for analysis. */
} PlantRole;

/** @brief What the values of a variable are. */
typedef enum {
    PLANT_REAL,        /**< Numbers in a unit. */
    PLANT_INTEGER,     /**< Integers of 32 bits. */
    PLANT_BOOLEAN,     /**< 0 and 1. */
    PLANT_ENUMERATION  /**< Numbers of items. */
} PlantType;

/** @brief A variable of the model. */
typedef struct {
    const char *name;      /**< Its name, as in the FMU. */
    const char *unit;      /**< Its unit; "" without one. */
    double start;          /**< Its default; 0 for computed variables. */
    double min;            /**< The smallest value that is accepted. */
    double max;            /**< The largest value that is accepted. */
    uint32_t reference;    /**< Its value reference. */
    uint16_t slot;         /**< The place of its value among all. */
    uint8_t role;          /**< A PlantRole. */
    uint8_t type;          /**< A PlantType. */
} PlantVariable;

/** @brief All PLANT_VARIABLES variables, in the order of their value references. */
extern const PlantVariable plant_variables[];

/** @brief A plant: its memory is static where PLANT_INSTANCES is defined, and otherwise allocated. */
typedef struct Plant Plant;

/** @brief Takes a message. It must return, and may not call a function of the plant. */
typedef void PlantLog(const char *text);

/** @brief Makes a plant with default parameters at time 0.
 *  @param log Takes messages; NULL: none.
 *  @return The plant, or NULL if there is no memory for one more, or the self-test fails where it must not. */
Plant *plant_init(PlantLog *log);

/** @brief Sets an input at any time, a fixed parameter before the start, a tunable one at any time.
 *  @param plant The plant.
 *  @param reference The value reference, REF_... of model.h.
 *  @param value The value in the SI unit of the variable.
 *  @return PLANT_ERROR if there is no such variable, it cannot be set now, or the value is out of range. */
PlantStatus plant_set(Plant *plant, uint32_t reference, double value);

/** @brief The same for an integer, a Boolean or an item of an enumeration. */
PlantStatus plant_choose(Plant *plant, uint32_t reference, int32_t value);

/** @brief Begins the run with the present parameters and inputs, without a step: from here on everything can be read.
 *  @return PLANT_ERROR if parameters do not fit together; they can be changed, and the start tried again. */
PlantStatus plant_start(Plant *plant);

/** @brief Goes on by a step; a plant that has not been started is started.
 *  @param plant The plant.
 *  @param step The size of the step in s, more than 0.
 *  @return PLANT_ERROR if the end cannot be reached, for example with the steps that solver.maxStepsPerCommunicationStep allows.
 *          The plant is then at the last time that the solver has reached, and can be read and go on. */
PlantStatus plant_step(Plant *plant, double step);

/** @brief The time in s that the plant has reached. */
double plant_time(const Plant *plant);

/** @brief Reads a variable: inputs and parameters at any time, computed variables from the start on. Computed values belong to
 *         the present inputs, also before the next step.
 *  @param plant The plant.
 *  @param reference The value reference.
 *  @param value Takes the value; Booleans are 0 and 1.
 *  @return PLANT_ERROR if there is no such variable, or it is not computed yet. */
PlantStatus plant_get(Plant *plant, uint32_t reference, double *value);

/** @brief Sets all inputs.
 *  @return PLANT_ERROR if one is out of range; none is changed then. */
PlantStatus plant_write(Plant *plant, const PlantInputs *inputs);

/** @brief Reads all outputs, from the start on. */
PlantStatus plant_read(Plant *plant, PlantOutputs *outputs);

/** @brief The variable of a name, or NULL. */
const PlantVariable *plant_find(const char *name);

/** @brief Frees the plant; NULL is fine. */
void plant_free(Plant *plant);

#ifdef __cplusplus
}
#endif

#endif
