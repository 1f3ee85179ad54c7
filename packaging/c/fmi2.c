/* The functions of FMI 2.0: each passes copies of its arrays to the function of the same name in the module,
   where all else is done. The header is the host's. */
#include "plant.h"

#if !defined(FMI2_OVERRIDE_FUNCTION_PREFIX) && !defined(FMI2_FUNCTION_PREFIX) && !defined(MODEL_IS_SHARED)
#define FMI2_FUNCTION_PREFIX MODEL_PREFIX
#endif
#include "fmi2Functions.h"

#define ENTER(name) PLANT_ENTER(p, c, name, fmi2Status)
#define LEAVE(status) return (fmi2Status)plant_leave(p, status)
#define S (&p->module)
#define C (p->component)
#define COUNT(number) PLANT_COUNT(p, number)

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

static void sink(Plant *plant, int status, const char *category, const char *text) {
    fmi2CallbackLogger logger = (fmi2CallbackLogger)plant->logger;
    if (logger) logger(plant->environment, plant->name, (fmi2Status)status, category, text);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    void (*logger)(void) = functions ? (void (*)(void))functions->logger : NULL;
    Plant *p = plant_new("fmi2Instantiate", name, sink, logger, functions ? functions->componentEnvironment : NULL);
    (void)resources, (void)visible;
    if (!p) {
        if (logger) {
            functions->logger(functions->componentEnvironment, name ? name : "", fmi2Error, "logStatusError",
                              "fmi2Instantiate: there is no memory for one more instance");
        }
        return NULL;
    }
    p->logs_formats = 1;
    if (setjmp(p->module.jump)) {
        plant_lost(p);
        plant_release(p);
        return NULL;
    }
    plant_reserve(p, PLANT_TEXT(name) + PLANT_TEXT(guid));
    {
        u32 of_name = plant_text(p, name), of_guid = plant_text(p, guid);
        u32 callbacks = logger ? wasm_plant_callbacks(S) : 0;
        return plant_ready(p, wasm_fmi2Instantiate(S, of_name, (u32)type, of_guid, 0, callbacks, 0, (u32)logging));
    }
}

void fmi2FreeInstance(fmi2Component c) {
    int refused = plant_enter(c, "fmi2FreeInstance");
    if (refused == PLANT_OK || refused == PLANT_FATAL) plant_release((Plant *)c);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t number, const fmi2String categories[]) {
    ENTER("fmi2SetDebugLogging")
    {
        u32 names = plant_texts(p, categories, number);
        LEAVE(wasm_fmi2SetDebugLogging(S, C, (u32)on, COUNT(number), names));
    }
}

/* Functions whose arguments go to the module as they are. */
#define PLAIN(name, declared, given)              \
    fmi2Status name declared {                    \
        ENTER(#name)                              \
        LEAVE(wasm_##name given);                 \
    }

PLAIN(fmi2SetupExperiment,
      (fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start, fmi2Boolean has_stop, fmi2Real stop),
      (S, C, (u32)has_tolerance, tolerance, start, (u32)has_stop, stop))
PLAIN(fmi2EnterInitializationMode, (fmi2Component c), (S, C))
PLAIN(fmi2ExitInitializationMode, (fmi2Component c), (S, C))
PLAIN(fmi2Terminate, (fmi2Component c), (S, C))
PLAIN(fmi2Reset, (fmi2Component c), (S, C))
PLAIN(fmi2EnterEventMode, (fmi2Component c), (S, C))
PLAIN(fmi2EnterContinuousTimeMode, (fmi2Component c), (S, C))
PLAIN(fmi2SetTime, (fmi2Component c, fmi2Real time), (S, C, time))
PLAIN(fmi2DoStep, (fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean is_final), (S, C, time, step, (u32)is_final))
PLAIN(fmi2CancelStep, (fmi2Component c), (S, C))
PLAIN(fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate state), (S, C, plant_state(p, state)))

/* Variables. There are none of type String, so that texts are neither read nor written. */
#define VALUES(name, of, type, size)                                                               \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, of type value[]) { \
        ENTER(#name)                                                                               \
        plant_reserve(p, PLANT_BYTES(nvr, 4) + PLANT_BYTES(nvr, size));                            \
        {                                                                                          \
            u32 references = plant_take(p, vr, nvr, 4), values = plant_take(p, value, nvr, size);  \
            u32 status = wasm_##name(S, C, references, COUNT(nvr), values);                        \
            GIVE(values, value, nvr, size)                                                         \
            LEAVE(status);                                                                         \
        }                                                                                          \
    }
#define GIVE(from, to, number, size) plant_give(p, from, to, number, size);
VALUES(fmi2GetReal, , fmi2Real, 8)
VALUES(fmi2GetInteger, , fmi2Integer, 4)
VALUES(fmi2GetBoolean, , fmi2Boolean, 4)
#undef GIVE
#define GIVE(from, to, number, size)
VALUES(fmi2GetString, , fmi2String, 4)
VALUES(fmi2SetReal, const, fmi2Real, 8)
VALUES(fmi2SetInteger, const, fmi2Integer, 4)
VALUES(fmi2SetBoolean, const, fmi2Boolean, 4)
VALUES(fmi2SetString, const, fmi2String, 4)

/* One value that is told. */
#define TOLD(name, type, size)                                              \
    fmi2Status name(fmi2Component c, const fmi2StatusKind kind, type *value) { \
        ENTER(#name)                                                        \
        plant_reserve(p, PLANT_BYTES(1u, size));                            \
        {                                                                   \
            u32 told = plant_take(p, value, 1, size);                       \
            u32 status = wasm_##name(S, C, (u32)kind, told);                \
            plant_give(p, told, value, 1, size);                            \
            LEAVE(status);                                                  \
        }                                                                   \
    }
TOLD(fmi2GetStatus, fmi2Status, sizeof(fmi2Status))
TOLD(fmi2GetRealStatus, fmi2Real, 8)
TOLD(fmi2GetIntegerStatus, fmi2Integer, 4)
TOLD(fmi2GetBooleanStatus, fmi2Boolean, 4)
TOLD(fmi2GetStringStatus, fmi2String, 4)

/* Vectors of a solver outside. */
#define VECTOR(name, of)                                               \
    fmi2Status name(fmi2Component c, of fmi2Real value[], size_t number) { \
        ENTER(#name)                                                   \
        plant_reserve(p, PLANT_BYTES(number, 8));                      \
        {                                                              \
            u32 values = plant_take(p, value, number, 8);              \
            u32 status = wasm_##name(S, C, values, COUNT(number));     \
            GIVE(values, value, number, 8)                             \
            LEAVE(status);                                             \
        }                                                              \
    }
VECTOR(fmi2SetContinuousStates, const)
#undef GIVE
#define GIVE(from, to, number, size) plant_give(p, from, to, number, size);
VECTOR(fmi2GetDerivatives, )
VECTOR(fmi2GetEventIndicators, )
VECTOR(fmi2GetContinuousStates, )
VECTOR(fmi2GetNominalsOfContinuousStates, )

/* Saved states. */
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    ENTER("fmi2GetFMUstate")
    LEAVE(plant_handle(p, state, wasm_fmi2GetFMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    ENTER("fmi2FreeFMUstate")
    LEAVE(plant_handle(p, state, wasm_fmi2FreeFMUstate));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    ENTER("fmi2SerializedFMUstateSize")
    LEAVE(plant_size(p, plant_state(p, state), size, wasm_fmi2SerializedFMUstateSize));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    ENTER("fmi2SerializeFMUstate")
    LEAVE(plant_serialize(p, plant_state(p, state), bytes, size, wasm_fmi2SerializeFMUstate));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    ENTER("fmi2DeSerializeFMUstate")
    LEAVE(plant_deserialize(p, bytes, size, state, wasm_fmi2DeSerializeFMUstate));
}

/* Derivatives. */
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t number_of_unknowns,
                                        const fmi2ValueReference knowns[], size_t number_of_knowns, const fmi2Real seeds[],
                                        fmi2Real derivatives[]) {
    ENTER("fmi2GetDirectionalDerivative")
    plant_reserve(p, PLANT_BYTES(number_of_unknowns, 12) + PLANT_BYTES(number_of_knowns, 12) + 32);
    {
        u32 of = plant_take(p, unknowns, number_of_unknowns, 4), by = plant_take(p, knowns, number_of_knowns, 4);
        u32 seed = plant_take(p, seeds, number_of_knowns, 8), values = plant_take(p, derivatives, number_of_unknowns, 8);
        u32 status = wasm_fmi2GetDirectionalDerivative(S, C, of, COUNT(number_of_unknowns), by, COUNT(number_of_knowns), seed, values);
        plant_give(p, values, derivatives, number_of_unknowns, 8);
        LEAVE(status);
    }
}

#define SLOPES(name, of)                                                                                        \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer orders[],    \
                    of fmi2Real value[]) {                                                                      \
        ENTER(#name)                                                                                            \
        plant_reserve(p, PLANT_BYTES(nvr, 16) + 32);                                                            \
        {                                                                                                       \
            u32 references = plant_take(p, vr, nvr, 4), order = plant_take(p, orders, nvr, 4);                  \
            u32 values = plant_take(p, value, nvr, 8);                                                          \
            u32 status = wasm_##name(S, C, references, COUNT(nvr), order, values);                              \
            GIVE(values, value, nvr, 8)                                                                         \
            LEAVE(status);                                                                                      \
        }                                                                                                       \
    }
SLOPES(fmi2GetRealOutputDerivatives, )
#undef GIVE
#define GIVE(from, to, number, size)
SLOPES(fmi2SetRealInputDerivatives, const)

/* Events. The structure has five Booleans, and a number at byte 24. */
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    ENTER("fmi2NewDiscreteStates")
    plant_reserve(p, PLANT_BYTES(32u, 1));
    {
        u64 room[4] = {0, 0, 0, 0};
        u32 told = plant_take(p, info ? room : NULL, 4, 8), status = wasm_fmi2NewDiscreteStates(S, C, told);
        if (status == PLANT_OK) {
            info->newDiscreteStatesNeeded = (fmi2Boolean)li(S->memory, told, 0);
            info->terminateSimulation = (fmi2Boolean)li(S->memory, told, 4);
            info->nominalsOfContinuousStatesChanged = (fmi2Boolean)li(S->memory, told, 8);
            info->valuesOfContinuousStatesChanged = (fmi2Boolean)li(S->memory, told, 12);
            info->nextEventTimeDefined = (fmi2Boolean)li(S->memory, told, 16);
            info->nextEventTime = ld(S->memory, told, 24);
        }
        LEAVE(status);
    }
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean is_final, fmi2Boolean *event, fmi2Boolean *end) {
    ENTER("fmi2CompletedIntegratorStep")
    plant_reserve(p, 2 * PLANT_BYTES(1u, 4));
    {
        u32 needs_event = plant_take(p, event, 1, 4), ends = plant_take(p, end, 1, 4);
        u32 status = wasm_fmi2CompletedIntegratorStep(S, C, (u32)is_final, needs_event, ends);
        plant_give(p, needs_event, event, 1, 4);
        plant_give(p, ends, end, 1, 4);
        LEAVE(status);
    }
}
