/* The plant without FMI, by the functions of FMI 2.0 in the module. */
#include "loop.h"

#include "plant.h"

static void sink_of_log(Plant *plant, int status, const char *category, const char *text) {
    PlantLog *log = (PlantLog *)plant->logger;
    (void)status, (void)category;
    if (log) log(text);
}

Plant *plant_init(PlantLog *log) {
    const char *name = "plant", *guid = MODEL_GUID;
    Plant *plant = plant_new("plant_init", name, sink_of_log, (void (*)(void))log, NULL);
    u32 component = 0;
    if (!plant) return NULL;
    if (setjmp(plant->module.jump)) {
        plant_lost(plant);
        plant_release(plant);
        return NULL;
    }
    plant_reserve(plant, PLANT_TEXT(name) + PLANT_TEXT(guid));
    if (plant->room) {
        u32 of_name = plant_text(plant, name), of_guid = plant_text(plant, guid);
        component = wasm_fmi2Instantiate(&plant->module, of_name, 1, of_guid, 0, wasm_plant_callbacks(&plant->module), 0, 0);
    }
    return plant_ready(plant, component);
}

/* Carries out a call of one value. */
static int with_value(Plant *plant, const char *function, u32 reference, void *value, unsigned size,
                      u32 call(Module *, u32, u32, u32, u32)) {
    PLANT_ENTER(p, plant, function, int)
    plant_reserve(p, PLANT_BYTES(1u, 4) + PLANT_BYTES(1u, size));
    {
        u32 references = plant_take(p, &reference, 1, 4), values = plant_take(p, value, 1, size);
        u32 status = call(&p->module, p->component, references, PLANT_COUNT(p, 1u), values);
        plant_give(p, values, value, 1, size);
        return plant_leave(p, status);
    }
}

int plant_set(Plant *plant, unsigned reference, double value) {
    return with_value(plant, "plant_set", reference, &value, sizeof value, wasm_fmi2SetReal);
}

int plant_choose(Plant *plant, unsigned reference, int value) {
    s32 number = value;
    return with_value(plant, "plant_choose", reference, &number, sizeof number, wasm_fmi2SetInteger);
}

int plant_get(Plant *plant, unsigned reference, double *value) {
    return with_value(plant, "plant_get", reference, value, sizeof *value, wasm_fmi2GetReal);
}

int plant_step(Plant *plant, double step) {
    u32 status = PLANT_OK;
    PLANT_ENTER(p, plant, "plant_step", int)
    if (!p->is_started) {
        status = wasm_fmi2SetupExperiment(&p->module, p->component, 0, 0.0, 0.0, 0, 0.0);
        if (!status) status = wasm_fmi2EnterInitializationMode(&p->module, p->component);
        if (!status) status = wasm_fmi2ExitInitializationMode(&p->module, p->component);
        p->is_started = !status;
    }
    if (!status) status = wasm_fmi2DoStep(&p->module, p->component, p->time, step, 1);
    if (!status) p->time += step;
    return plant_leave(p, status);
}

void plant_free(Plant *plant) {
    if (plant && !plant_enter(plant, "plant_free")) plant_release(plant);
    else if (plant && plant->is_lost) plant_release(plant);
}
