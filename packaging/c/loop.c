/* The plant without FMI: values stand one behind the other in the memory of the module, inputs first, then parameters and what is
   computed. The table in model.c says which is which. */
#include "plant.h"

static void sink_of_log(Plant *plant, int status, const char *category, const char *text) {
    PlantLog *log = (PlantLog *)plant->logger;
    (void)status;
    (void)category;
    if (log != NULL) {
        log(text);
    }
}

static PlantStatus refuse(Plant *plant, const char *text, const char *more) {
    plant_tell(plant, PLANT_ERROR, "error", text, more);
    return PLANT_ERROR;
}

/* The value in a slot. */
static double value_in(const Plant *plant, unsigned slot) { return ldu(plant->module.memory, plant->values, 8u * slot); }

static void put(Plant *plant, unsigned slot, double value) { sdu(plant->module.memory, plant->values, 8u * slot, value); }

/* The variable of a value reference; NULL, and a message, if there is none. */
static const PlantVariable *variable_of(Plant *plant, uint32_t reference) {
    unsigned low = 0, high = PLANT_VARIABLES;
    while (low < high) {
        unsigned middle = (low + high) / 2u;
        if (plant_variables[middle].reference < reference) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if (low < PLANT_VARIABLES && plant_variables[low].reference == reference) {
        return &plant_variables[low];
    }
    (void)refuse(plant, "there is no variable with this value reference", "");
    return NULL;
}

/* A number with six digits, as in 1.5e-3, behind a text that has room for 16 letters more. */
static void append_number(char *text, double value) {
    char *end = text + strlen(text);
    double rest = value;
    int exponent = 0, place, last = 7;
    uint32_t digits;
    if (value != value) {
        (void)strcpy(end, "NaN");
        return;
    }
    if ((value - value) != 0.0) {
        (void)strcpy(end, (value < 0.0) ? "-inf" : "inf");
        return;
    }
    if (rest < 0.0) {
        *end = '-';
        end++;
        rest = -rest;
    }
    while (rest >= 10.0) {
        rest /= 10.0;
        exponent++;
    }
    while ((rest < 1.0) && (rest > 0.0)) {
        rest *= 10.0;
        exponent--;
    }
    rest = (rest * 1e5) + 0.5;
    digits = (uint32_t)rest;
    if (digits >= 1000000u) {
        digits /= 10u;
        exponent++;
    }
    for (place = 6; place > 0; place--) {
        end[(place == 1) ? 0 : place] = (char)('0' + (int)(digits % 10u));
        digits /= 10u;
    }
    end[1] = '.';
    while ((last > 3) && (end[last - 1] == '0')) {
        last--;
    }
    end += last;
    if (exponent != 0) {
        *end = 'e';
        end++;
        if (exponent < 0) {
            *end = '-';
            end++;
            exponent = -exponent;
        }
        for (place = 100; place > 0; place /= 10) {
            if ((exponent >= place) || (place == 1)) {
                *end = (char)('0' + ((exponent / place) % 10));
                end++;
            }
        }
    }
    *end = '\0';
}

/* Whether a value is one that a variable may have; a message if it is not. */
static int is_legal(Plant *plant, const PlantVariable *variable, double value) {
    char text[128];
    int is_whole = variable->type == PLANT_REAL || value == floor(value);
    if (is_whole && value >= variable->min && value <= variable->max) {
        return 1;
    }
    text[0] = '\0';
    (void)strcat(text, " = ");
    append_number(text, value);
    (void)strcat(text, is_whole ? " is refused: it must be from " : " is refused: it must be a whole number from ");
    append_number(text, variable->min);
    (void)strcat(text, " to ");
    append_number(text, variable->max);
    (void)refuse(plant, variable->name, text);
    return 0;
}

static PlantStatus set(Plant *plant, uint32_t reference, double value) {
    const PlantVariable *variable = variable_of(plant, reference);
    double before;
    PlantStatus status = PLANT_OK;
    if (variable == NULL) {
        return PLANT_ERROR;
    }
    if (variable->role == PLANT_FIXED && plant->is_started) {
        return refuse(plant, variable->name, " is fixed once the run has begun");
    }
    if (variable->role != PLANT_INPUT && variable->role != PLANT_FIXED && variable->role != PLANT_TUNABLE) {
        return refuse(plant, variable->name, " is computed and cannot be set");
    }
    if (!is_legal(plant, variable, value)) {
        return PLANT_ERROR;
    }
    before = value_in(plant, variable->slot);
    put(plant, variable->slot, value);
    if (variable->role == PLANT_TUNABLE && plant->is_started) {
        status = (PlantStatus)wasm_loop_retune(&plant->module);
        if (status != PLANT_OK) {
            put(plant, variable->slot, before);
        }
    }
    plant->is_computed = 0;
    return status;
}

static PlantStatus start(Plant *plant) {
    PlantStatus status = (PlantStatus)wasm_loop_start(&plant->module);
    plant->is_started = status == PLANT_OK;
    plant->is_computed = 0;
    return status;
}

static PlantStatus advance(Plant *plant, double end) {
    PlantStatus status = (PlantStatus)wasm_loop_advance(&plant->module, end);
    plant->time = status == PLANT_OK ? end : wasm_loop_time(&plant->module);
    plant->is_computed = 0;
    return status;
}

/* Updates computed values for the present inputs. */
static void compute(Plant *plant) {
    if (!plant->is_computed) {
        wasm_loop_read(&plant->module);
    }
    plant->is_computed = 1;
}

/* Room for the values, which are defaults; 0 without memory. */
static int prepare(Plant *plant) {
    unsigned place;
    plant->values = wasm_loop_room(&plant->module, PLANT_INPUTS, PLANT_PARAMETERS, PLANT_COMPUTED);
    if (!plant->values || plant->values > MEMORY - 8u * (PLANT_INPUTS + PLANT_PARAMETERS + PLANT_COMPUTED)) {
        return 0;
    }
    for (place = 0; place < PLANT_VARIABLES; place++) {
        const PlantVariable *variable = &plant_variables[place];
        if (variable->role == PLANT_INPUT || variable->role == PLANT_FIXED || variable->role == PLANT_TUNABLE) {
            put(plant, variable->slot, variable->start);
        }
    }
    plant->time = 0.0;
    plant->is_started = 0;
    plant->is_computed = 0;
    return 1;
}

#if PLANT_SELF_TEST
/* The fingerprint of a run of the default experiment, as the FMU computes it: the 64-bit FNV-1a hash of all that is computed,
   after every step. */
static u64 fingerprint_of(Plant *plant) {
    u64 hash = 0xcbf29ce484222325ull;
    unsigned step, slot;
    int byte;
    if (start(plant) != PLANT_OK) {
        return 0;
    }
    for (step = 0; step < plant_test_steps; step++) {
        for (slot = 0; slot < PLANT_INPUTS; slot++) {
            put(plant, slot, plant_test_inputs[(step * PLANT_INPUTS) + slot]);
        }
        if (advance(plant, (step + 1) * plant_test_step) != PLANT_OK) {
            return 0;
        }
        compute(plant);
        for (slot = PLANT_INPUTS + PLANT_PARAMETERS; slot < PLANT_INPUTS + PLANT_PARAMETERS + PLANT_COMPUTED; slot++) {
            u64 bits = bits64(value_in(plant, slot));
            for (byte = 0; byte < 8; byte++) {
                hash = (hash ^ ((bits >> (8 * byte)) & 255u)) * 0x100000001b3ull;
            }
        }
    }
    return hash;
}
#endif

Plant *plant_init(PlantLog *log) {
    Plant *plant = plant_new("plant_init", "plant", sink_of_log, (void (*)(void))log, NULL);
    int is_ready;
    if (plant == NULL) {
        return NULL;
    }
    if (setjmp(plant->module.jump)) {
        (void)plant_lost(plant);
        plant_release(plant);
        return NULL;
    }
#ifdef wasm_loop_memory
    wasm_loop_memory(&plant->module, MEMORY);
#endif
    is_ready = prepare(plant);
#if PLANT_SELF_TEST
    is_ready = is_ready && plant_passes(plant, fingerprint_of(plant)) && prepare(plant);
#endif
    if (!is_ready) {
        plant_release(plant);
        return NULL;
    }
    (void)plant_leave(plant, PLANT_OK);
    return plant;
}

/* What a function is called with. */
typedef struct {
    uint32_t reference;
    double value;
    double *result;
    const PlantInputs *inputs;
    PlantOutputs *outputs;
} Arguments;

/* Carries out a call: from here a trap comes back. */
static PlantStatus carry_out(Plant *plant, const char *function, PlantStatus body(Plant *, const Arguments *),
                             const Arguments *arguments) {
    PLANT_ENTER(p, plant, function, PlantStatus)
    return (PlantStatus)plant_leave(p, (u32)body(p, arguments));
}

static PlantStatus body_of_set(Plant *plant, const Arguments *arguments) {
    return set(plant, arguments->reference, arguments->value);
}

PlantStatus plant_set(Plant *plant, uint32_t reference, double value) {
    Arguments arguments = {reference, value, NULL, NULL, NULL};
    return carry_out(plant, "plant_set", body_of_set, &arguments);
}

PlantStatus plant_choose(Plant *plant, uint32_t reference, int32_t value) {
    Arguments arguments = {reference, (double)value, NULL, NULL, NULL};
    return carry_out(plant, "plant_choose", body_of_set, &arguments);
}

static PlantStatus body_of_start(Plant *plant, const Arguments *arguments) {
    (void)arguments;
    return plant->is_started ? refuse(plant, "the run has begun already", "") : start(plant);
}

PlantStatus plant_start(Plant *plant) { return carry_out(plant, "plant_start", body_of_start, NULL); }

static PlantStatus body_of_step(Plant *plant, const Arguments *arguments) {
    PlantStatus status = PLANT_OK;
    double end = plant->time + arguments->value;
    if (!(end > plant->time) || end - end != 0.0) {
        return refuse(plant, "the step must be a positive number that the time resolves", "");
    }
    if (!plant->is_started) {
        status = start(plant);
    }
    return (status == PLANT_OK) ? advance(plant, end) : status;
}

PlantStatus plant_step(Plant *plant, double step) {
    Arguments arguments = {0, step, NULL, NULL, NULL};
    return carry_out(plant, "plant_step", body_of_step, &arguments);
}

double plant_time(const Plant *plant) { return plant->time; }

static PlantStatus body_of_get(Plant *plant, const Arguments *arguments) {
    const PlantVariable *variable = variable_of(plant, arguments->reference);
    if (variable == NULL) {
        return PLANT_ERROR;
    }
    if (!arguments->result) {
        return refuse(plant, variable->name, " has no room for its value: the pointer is NULL");
    }
    if (variable->role == PLANT_TIME) {
        *arguments->result = plant->time;
        return PLANT_OK;
    }
    if (variable->role == PLANT_OUTPUT || variable->role == PLANT_LOCAL) {
        if (!plant->is_started) {
            return refuse(plant, variable->name, " is computed from the start on: call plant_start");
        }
        compute(plant);
    }
    *arguments->result = value_in(plant, variable->slot);
    return PLANT_OK;
}

PlantStatus plant_get(Plant *plant, uint32_t reference, double *value) {
    Arguments arguments = {reference, 0.0, value, NULL, NULL};
    return carry_out(plant, "plant_get", body_of_get, &arguments);
}

/* The variable in a slot of the inputs. */
static const PlantVariable *input_in(unsigned slot) {
    const PlantVariable *variable = plant_variables;
    while ((variable->role != PLANT_INPUT) || (variable->slot != slot)) {
        variable++;
    }
    return variable;
}

static PlantStatus body_of_write(Plant *plant, const Arguments *arguments) {
    double values[PLANT_INPUTS > 0 ? PLANT_INPUTS : 1];
    unsigned slot;
    if (!arguments->inputs) {
        return refuse(plant, "the inputs are NULL", "");
    }
    plant_inputs_of(arguments->inputs, values);
    for (slot = 0; slot < PLANT_INPUTS; slot++) {
        if (!is_legal(plant, input_in(slot), values[slot])) {
            return PLANT_ERROR;
        }
    }
    for (slot = 0; slot < PLANT_INPUTS; slot++) {
        put(plant, slot, values[slot]);
    }
    plant->is_computed = 0;
    return PLANT_OK;
}

PlantStatus plant_write(Plant *plant, const PlantInputs *inputs) {
    Arguments arguments = {0, 0.0, NULL, inputs, NULL};
    return carry_out(plant, "plant_write", body_of_write, &arguments);
}

static PlantStatus body_of_read(Plant *plant, const Arguments *arguments) {
    double values[PLANT_OUTPUTS > 0 ? PLANT_OUTPUTS : 1];
    unsigned place;
    if (!arguments->outputs) {
        return refuse(plant, "there is no room for the outputs: the pointer is NULL", "");
    }
    if (!plant->is_started) {
        return refuse(plant, "outputs are computed from the start on: call plant_start", "");
    }
    compute(plant);
    for (place = 0; place < PLANT_OUTPUTS; place++) {
        values[place] = value_in(plant, plant_output_slots[place]);
    }
    plant_outputs_of(values, arguments->outputs);
    return PLANT_OK;
}

PlantStatus plant_read(Plant *plant, PlantOutputs *outputs) {
    Arguments arguments = {0, 0.0, NULL, NULL, outputs};
    return carry_out(plant, "plant_read", body_of_read, &arguments);
}

const PlantVariable *plant_find(const char *name) {
    unsigned place;
    for (place = 0; place < PLANT_VARIABLES; place++) {
        if (strcmp(plant_variables[place].name, name) == 0) {
            return &plant_variables[place];
        }
    }
    return NULL;
}

void plant_free(Plant *plant) {
    if (plant == NULL) {
        return;
    }
    if ((plant_enter(plant, "plant_free") == PLANT_OK) || plant->is_lost) {
        plant_release(plant);
    }
}
