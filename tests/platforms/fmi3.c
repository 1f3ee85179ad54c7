/* FMI 3.0: co-simulation, the same with event mode and steps that return early, and model exchange. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi3FunctionTypes.h"
#include "host.h"

static struct {
    fmi3InstantiateCoSimulationTYPE *instantiate_co_simulation;
    fmi3InstantiateModelExchangeTYPE *instantiate_model_exchange;
    fmi3FreeInstanceTYPE *free_instance;
    fmi3EnterInitializationModeTYPE *enter_initialization;
    fmi3ExitInitializationModeTYPE *exit_initialization;
    fmi3EnterEventModeTYPE *enter_event;
    fmi3UpdateDiscreteStatesTYPE *update;
    fmi3EnterStepModeTYPE *enter_step;
    fmi3EnterContinuousTimeModeTYPE *enter_continuous_time;
    fmi3TerminateTYPE *terminate;
    fmi3SetFloat64TYPE *set_float;
    fmi3SetInt64TYPE *set_enumeration;
    fmi3GetFloat64TYPE *get_float;
    fmi3DoStepTYPE *do_step;
    fmi3SetTimeTYPE *set_time;
    fmi3GetNumberOfContinuousStatesTYPE *number_of_states;
    fmi3GetNumberOfEventIndicatorsTYPE *number_of_indicators;
    fmi3GetContinuousStatesTYPE *get_states;
    fmi3SetContinuousStatesTYPE *set_states;
    fmi3GetContinuousStateDerivativesTYPE *get_derivatives;
    fmi3GetEventIndicatorsTYPE *get_indicators;
    fmi3CompletedIntegratorStepTYPE *completed_step;
    fmi3GetFMUStateTYPE *get_state;
    fmi3SetFMUStateTYPE *set_state;
    fmi3FreeFMUStateTYPE *free_state;
    fmi3SerializedFMUStateSizeTYPE *serialized_size;
    fmi3SerializeFMUStateTYPE *serialize;
    fmi3DeserializeFMUStateTYPE *deserialize;
} fmi;

static fmi3Instance instance;

static void load(void) {
#define LOAD(member, name) *(void **)&fmi.member = function("fmi3" name)
    LOAD(instantiate_co_simulation, "InstantiateCoSimulation");
    LOAD(instantiate_model_exchange, "InstantiateModelExchange");
    LOAD(free_instance, "FreeInstance");
    LOAD(enter_initialization, "EnterInitializationMode");
    LOAD(exit_initialization, "ExitInitializationMode");
    LOAD(enter_event, "EnterEventMode");
    LOAD(update, "UpdateDiscreteStates");
    LOAD(enter_step, "EnterStepMode");
    LOAD(enter_continuous_time, "EnterContinuousTimeMode");
    LOAD(terminate, "Terminate");
    LOAD(set_float, "SetFloat64");
    LOAD(set_enumeration, "SetInt64");
    LOAD(get_float, "GetFloat64");
    LOAD(do_step, "DoStep");
    LOAD(set_time, "SetTime");
    LOAD(number_of_states, "GetNumberOfContinuousStates");
    LOAD(number_of_indicators, "GetNumberOfEventIndicators");
    LOAD(get_states, "GetContinuousStates");
    LOAD(set_states, "SetContinuousStates");
    LOAD(get_derivatives, "GetContinuousStateDerivatives");
    LOAD(get_indicators, "GetEventIndicators");
    LOAD(completed_step, "CompletedIntegratorStep");
    LOAD(get_state, "GetFMUState");
    LOAD(set_state, "SetFMUState");
    LOAD(free_state, "FreeFMUState");
    LOAD(serialized_size, "SerializedFMUStateSize");
    LOAD(serialize, "SerializeFMUState");
    LOAD(deserialize, "DeserializeFMUState");
}

static void print_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text) {
    (void)environment;
    fprintf(stderr, "host: status %d, %s: %s\n", status, category, text);
}

static void choose(uint32_t reference, int item) {
    fmi3Int64 value = item;
    CALL(fmi.set_enumeration(instance, &reference, 1, &value, 1));
}

static void set(const uint32_t *references, size_t count, const double *values) {
    CALL(fmi.set_float(instance, references, count, values, count));
}

static void initialize(void) {
    CALL(fmi.enter_initialization(instance, fmi3False, 0.0, 0.0, fmi3False, 0.0));
    CALL(fmi.exit_initialization(instance));
}

static void get(const uint32_t *references, size_t count, double *values) {
    CALL(fmi.get_float(instance, references, count, values, count));
}

#include "alike.h"

/* Co-simulation. */

static void instantiate_steps(const char *name, const char *token, fmi3Boolean events) {
    instance = fmi.instantiate_co_simulation(
        name, token, NULL, fmi3False, fmi3False, events, events, NULL, 0, NULL, print_message, NULL);
    if (!instance) fail("fmi3InstantiateCoSimulation");
}

static void instantiate(const char *name, const char *token) { instantiate_steps(name, token, fmi3False); }

/* Where the step has led, and whether an event waits there. */
static double step_to(double time, double size, fmi3Boolean *event) {
    fmi3Boolean terminate, early;
    CALL(fmi.do_step(instance, time, size, fmi3True, event, &terminate, &early, &time));
    if (terminate) fail("taking a step");
    return time;
}

static void take_step(double time, double size) {
    fmi3Boolean event;
    step_to(time, size, &event);
}

const struct face fmi3 = {
    "fmi3", load, instantiate, choose, set, initialize, take_step, width, get,
    save, restore, forget, serialized_size, serialize, deserialize, finish};

/* Co-simulation with event mode. */

static void instantiate_with_events(const char *name, const char *token) { instantiate_steps(name, token, fmi3True); }

/* When the next event is certain, or infinity. */
static double update(void) {
    fmi3Boolean again = fmi3True, terminate, nominals, values, is_defined;
    double next;
    while (again) CALL(fmi.update(instance, &again, &terminate, &nominals, &values, &is_defined, &next));
    return is_defined ? next : HUGE_VAL;
}

static void initialize_with_events(void) {
    initialize();
    update();
    CALL(fmi.enter_step(instance));
}

/* To every event on the way, and to the end. */
static void take_step_with_events(double time, double size) {
    double end = time + size;
    while (time < end) {
        fmi3Boolean event;
        time = step_to(time, end - time, &event);
        if (event) {
            CALL(fmi.enter_event(instance));
            update();
            CALL(fmi.enter_step(instance));
        }
    }
}

const struct face fmi3_events = {
    "fmi3-events", load, instantiate_with_events, choose, set, initialize_with_events, take_step_with_events, width, get,
    save, restore, forget, serialized_size, serialize, deserialize, finish};

/* Model exchange. */

enum { SUBSTEPS = 100 };

/* The solver: states, their derivatives, event indicators and what they were before. */
static struct {
    size_t states, indicators;
    double *x, *rates, *z, *z_before;
} solver;

static void instantiate_exchange(const char *name, const char *token) {
    instance = fmi.instantiate_model_exchange(name, token, NULL, fmi3False, fmi3False, NULL, print_message);
    if (!instance) fail("fmi3InstantiateModelExchange");
    CALL(fmi.number_of_states(instance, &solver.states));
    CALL(fmi.number_of_indicators(instance, &solver.indicators));
    solver.x = array(solver.states, sizeof *solver.x);
    solver.rates = array(solver.states, sizeof *solver.rates);
    solver.z = array(solver.indicators, sizeof *solver.z);
    solver.z_before = array(solver.indicators, sizeof *solver.z_before);
}

static void initialize_exchange(void) {
    initialize();
    update();
    CALL(fmi.enter_continuous_time(instance));
}

/* When the next event is certain. */
static double pass_event(void) {
    CALL(fmi.enter_event(instance));
    double next = update();
    CALL(fmi.enter_continuous_time(instance));
    CALL(fmi.get_indicators(instance, solver.z_before, solver.indicators));
    return next;
}

/* Moves by the explicit Euler method; leaves indicators. */
static void move(double from, double to) {
    CALL(fmi.get_states(instance, solver.x, solver.states));
    CALL(fmi.get_derivatives(instance, solver.rates, solver.states));
    for (size_t i = 0; i < solver.states; i++) solver.x[i] += (to - from) * solver.rates[i];
    CALL(fmi.set_time(instance, to));
    CALL(fmi.set_states(instance, solver.x, solver.states));
    fmi3Boolean event, terminate;
    CALL(fmi.completed_step(instance, fmi3True, &event, &terminate));
    if (event || terminate) fail("moving");
    CALL(fmi.get_indicators(instance, solver.z, solver.indicators));
}

/* Integrates to the end of a communication step in small equal steps, which end at events too. Inputs may have jumped at
 * its beginning. */
static void integrate(double time, double size) {
    double begin = time, next = pass_event();
    for (int i = 0; i < SUBSTEPS; i++) {
        double end = begin + size * (i + 1) / SUBSTEPS;
        while (time < end) {
            double to = next > time && next < end ? next : end;
            move(time, to);
            int crossed = to == next;
            for (size_t k = 0; k < solver.indicators; k++) crossed |= (solver.z[k] > 0.0) != (solver.z_before[k] > 0.0);
            if (crossed) next = pass_event();
            time = to;
        }
    }
}

static size_t width_of_exchange(size_t count) { return count + 2 * solver.states + solver.indicators; }

static void get_exchange(const uint32_t *references, size_t count, double *values) {
    get(references, count, values);
    CALL(fmi.get_states(instance, values += count, solver.states));
    CALL(fmi.get_derivatives(instance, values += solver.states, solver.states));
    CALL(fmi.get_indicators(instance, values + solver.states, solver.indicators));
}

static void finish_exchange(void) {
    finish();
    free(solver.x), free(solver.rates), free(solver.z), free(solver.z_before);
}

const struct face fmi3_exchange = {
    "fmi3-exchange", load, instantiate_exchange, choose, set, initialize_exchange, integrate, width_of_exchange,
    get_exchange, save, restore, forget, serialized_size, serialize, deserialize, finish_exchange};
