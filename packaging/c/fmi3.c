/* The functions of FMI 3.0: each passes copies of its arrays to the function of the same name in the module,
   where all else is done. The header is the host's. */
#include "plant.h"

#if !defined(FMI3_OVERRIDE_FUNCTION_PREFIX) && !defined(FMI3_FUNCTION_PREFIX) && !defined(MODEL_IS_SHARED)
#define FMI3_FUNCTION_PREFIX MODEL_PREFIX
#endif
#include "fmi3Functions.h"

#define ENTER(name) PLANT_ENTER(p, c, name, fmi3Status)
#define LEAVE(status) return (fmi3Status)plant_leave(p, status)
#define S (&p->module)
#define C (p->component)
#define COUNT(number) PLANT_COUNT(p, number)

const char *fmi3GetVersion(void) { return "3.0"; }

static void sink(Plant *plant, int status, const char *category, const char *text) {
    fmi3LogMessageCallback logger = (fmi3LogMessageCallback)plant->logger;
    if (logger) logger(plant->environment, (fmi3Status)status, category, text);
}

/* A plant for an instance, with room for its name and token. */
static Plant *begin(const char *function, fmi3String name, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    Plant *p = plant_new(function, name, sink, (void (*)(void))log, environment);
    if (!p && log) log(environment, fmi3Error, "logStatusError", "there is no memory for one more instance");
    return p;
}

static Plant *give_up(Plant *p) {
    plant_lost(p);
    plant_release(p);
    return NULL;
}

/* The logger, as the module has it. */
#define LOGGER (log ? wasm_plant_logger(S) : 0)

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    Plant *p = begin("fmi3InstantiateModelExchange", name, environment, log);
    (void)resources;
    if (!p) return NULL;
    if (setjmp(p->module.jump)) return give_up(p);
    plant_reserve(p, PLANT_TEXT(name) + PLANT_TEXT(token));
    {
        u32 of_name = plant_text(p, name), of_token = plant_text(p, token);
        return plant_ready(p, wasm_fmi3InstantiateModelExchange(S, of_name, of_token, 0, visible, logging, 0, LOGGER));
    }
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t number,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    Plant *p = begin("fmi3InstantiateCoSimulation", name, environment, log);
    (void)resources, (void)required, (void)update;
    if (!p) return NULL;
    if (setjmp(p->module.jump)) return give_up(p);
    plant_reserve(p, PLANT_TEXT(name) + PLANT_TEXT(token));
    {
        u32 of_name = plant_text(p, name), of_token = plant_text(p, token);
        return plant_ready(p, wasm_fmi3InstantiateCoSimulation(S, of_name, of_token, 0, visible, logging, event_mode,
                                                               early_return, 0, COUNT(number), 0, LOGGER, 0));
    }
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    Plant *p = begin("fmi3InstantiateScheduledExecution", name, environment, log);
    (void)resources, (void)update, (void)lock, (void)unlock;
    if (!p) return NULL;
    if (setjmp(p->module.jump)) return give_up(p);
    plant_reserve(p, PLANT_TEXT(name) + PLANT_TEXT(token));
    {
        u32 of_name = plant_text(p, name), of_token = plant_text(p, token);
        return plant_ready(p, wasm_fmi3InstantiateScheduledExecution(S, of_name, of_token, 0, visible, logging, 0, LOGGER, 0, 0, 0));
    }
}

void fmi3FreeInstance(fmi3Instance c) {
    int refused = plant_enter(c, "fmi3FreeInstance");
    if (refused == PLANT_OK || refused == PLANT_FATAL) plant_release((Plant *)c);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t number, const fmi3String categories[]) {
    ENTER("fmi3SetDebugLogging")
    {
        u32 names = plant_texts(p, categories, number);
        LEAVE(wasm_fmi3SetDebugLogging(S, C, on, COUNT(number), names));
    }
}

/* Functions whose arguments go to the module as they are. */
#define PLAIN(name, declared, given)              \
    fmi3Status name declared {                    \
        ENTER(#name)                              \
        LEAVE(wasm_##name given);                 \
    }

PLAIN(fmi3EnterInitializationMode,
      (fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop),
      (S, C, has_tolerance, tolerance, start, has_stop, stop))
PLAIN(fmi3ExitInitializationMode, (fmi3Instance c), (S, C))
PLAIN(fmi3EnterEventMode, (fmi3Instance c), (S, C))
PLAIN(fmi3Terminate, (fmi3Instance c), (S, C))
PLAIN(fmi3Reset, (fmi3Instance c), (S, C))
PLAIN(fmi3EnterConfigurationMode, (fmi3Instance c), (S, C))
PLAIN(fmi3ExitConfigurationMode, (fmi3Instance c), (S, C))
PLAIN(fmi3EvaluateDiscreteStates, (fmi3Instance c), (S, C))
PLAIN(fmi3EnterContinuousTimeMode, (fmi3Instance c), (S, C))
PLAIN(fmi3EnterStepMode, (fmi3Instance c), (S, C))
PLAIN(fmi3SetTime, (fmi3Instance c, fmi3Float64 time), (S, C, time))
PLAIN(fmi3SetFMUState, (fmi3Instance c, fmi3FMUState state), (S, C, plant_state(p, state)))
PLAIN(fmi3ActivateModelPartition, (fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time), (S, C, clock, time))

/* Variables. */
#define VALUES(name, of, type)                                                                                 \
    fmi3Status name(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, of type value[], size_t room) { \
        ENTER(#name)                                                                                           \
        plant_reserve(p, PLANT_BYTES(nvr, 4) + PLANT_BYTES(room, sizeof(type)));                               \
        {                                                                                                      \
            u32 references = plant_take(p, vr, nvr, 4), values = plant_take(p, value, room, sizeof(type));     \
            u32 status = wasm_##name(S, C, references, COUNT(nvr), values, COUNT(room));                       \
            GIVE(values, value, room, sizeof(type))                                                            \
            LEAVE(status);                                                                                     \
        }                                                                                                      \
    }
#define GIVE(from, to, number, size) plant_give(p, from, to, number, size);
VALUES(fmi3GetFloat32, , fmi3Float32)
VALUES(fmi3GetFloat64, , fmi3Float64)
VALUES(fmi3GetInt8, , fmi3Int8)
VALUES(fmi3GetUInt8, , fmi3UInt8)
VALUES(fmi3GetInt16, , fmi3Int16)
VALUES(fmi3GetUInt16, , fmi3UInt16)
VALUES(fmi3GetInt32, , fmi3Int32)
VALUES(fmi3GetUInt32, , fmi3UInt32)
VALUES(fmi3GetInt64, , fmi3Int64)
VALUES(fmi3GetUInt64, , fmi3UInt64)
VALUES(fmi3GetBoolean, , fmi3Boolean)
#undef GIVE
#define GIVE(from, to, number, size)
VALUES(fmi3SetFloat32, const, fmi3Float32)
VALUES(fmi3SetFloat64, const, fmi3Float64)
VALUES(fmi3SetInt8, const, fmi3Int8)
VALUES(fmi3SetUInt8, const, fmi3UInt8)
VALUES(fmi3SetInt16, const, fmi3Int16)
VALUES(fmi3SetUInt16, const, fmi3UInt16)
VALUES(fmi3SetInt32, const, fmi3Int32)
VALUES(fmi3SetUInt32, const, fmi3UInt32)
VALUES(fmi3SetInt64, const, fmi3Int64)
VALUES(fmi3SetUInt64, const, fmi3UInt64)
VALUES(fmi3SetBoolean, const, fmi3Boolean)

/* Variables of types that there are none of: only their value references are looked at. */
#define ABSENT(name, declared, given)                                                                \
    fmi3Status name declared {                                                                       \
        ENTER(#name)                                                                                 \
        plant_reserve(p, PLANT_BYTES(nvr, 4));                                                       \
        {                                                                                            \
            u32 references = plant_take(p, vr, nvr, 4);                                              \
            LEAVE(wasm_##name given);                                                                \
        }                                                                                            \
    }
ABSENT(fmi3GetString, (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3String values[], size_t room),
       (S, C, references, COUNT(nvr), values != NULL, COUNT(room)))
ABSENT(fmi3SetString, (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3String values[], size_t room),
       (S, C, references, COUNT(nvr), values != NULL, COUNT(room)))
ABSENT(fmi3GetBinary,
       (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, size_t sizes[], fmi3Binary values[], size_t room),
       (S, C, references, COUNT(nvr), sizes != NULL, values != NULL, COUNT(room)))
ABSENT(fmi3SetBinary,
       (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const size_t sizes[], const fmi3Binary values[], size_t room),
       (S, C, references, COUNT(nvr), sizes != NULL, values != NULL, COUNT(room)))
ABSENT(fmi3GetClock, (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Clock values[]),
       (S, C, references, COUNT(nvr), values != NULL))
ABSENT(fmi3SetClock, (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Clock values[]),
       (S, C, references, COUNT(nvr), values != NULL))
ABSENT(fmi3GetIntervalDecimal,
       (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Float64 values[], fmi3IntervalQualifier qualifiers[]),
       (S, C, references, COUNT(nvr), values != NULL, qualifiers != NULL))
ABSENT(fmi3GetIntervalFraction,
       (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
        fmi3IntervalQualifier qualifiers[]),
       (S, C, references, COUNT(nvr), counters != NULL, resolutions != NULL, qualifiers != NULL))
ABSENT(fmi3GetShiftDecimal, (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Float64 values[]),
       (S, C, references, COUNT(nvr), values != NULL))
ABSENT(fmi3GetShiftFraction,
       (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3UInt64 counters[], fmi3UInt64 resolutions[]),
       (S, C, references, COUNT(nvr), counters != NULL, resolutions != NULL))
ABSENT(fmi3SetIntervalDecimal, (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Float64 values[]),
       (S, C, references, COUNT(nvr), values != NULL))
ABSENT(fmi3SetIntervalFraction,
       (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]),
       (S, C, references, COUNT(nvr), counters != NULL, resolutions != NULL))
ABSENT(fmi3SetShiftDecimal, (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Float64 values[]),
       (S, C, references, COUNT(nvr), values != NULL))
ABSENT(fmi3SetShiftFraction,
       (fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]),
       (S, C, references, COUNT(nvr), counters != NULL, resolutions != NULL))

/* What variables depend on. */
fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference reference, size_t *number) {
    ENTER("fmi3GetNumberOfVariableDependencies")
    LEAVE(plant_size(p, reference, number, wasm_fmi3GetNumberOfVariableDependencies));
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
                                       fmi3ValueReference independents[], size_t elements_of_independents[],
                                       fmi3DependencyKind kinds[], size_t number) {
    ENTER("fmi3GetVariableDependencies")
    plant_reserve(p, PLANT_BYTES(number, 16) + 64);
    {
        /* Arrays of sizes need room only: the module's sizes have 32 bits. */
        u32 element = plant_take(p, elements, number, 4), others = plant_take(p, independents, number, 4);
        u32 element_of_others = plant_take(p, elements_of_independents, number, 4), kind = plant_take(p, kinds, number, 4);
        u32 status = wasm_fmi3GetVariableDependencies(S, C, dependent, element, others, element_of_others, kind, COUNT(number));
        if (status == PLANT_OK) {
            size_t place;
            for (place = 0; place < number; place++) {
                elements[place] = li(S->memory, element + 4u * (u32)place, 0);
                elements_of_independents[place] = li(S->memory, element_of_others + 4u * (u32)place, 0);
                kinds[place] = (fmi3DependencyKind)li(S->memory, kind + 4u * (u32)place, 0);
            }
            plant_give(p, others, independents, number, 4);
        }
        LEAVE(status);
    }
}

/* Saved states. */
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    ENTER("fmi3GetFMUState")
    LEAVE(plant_handle(p, state, wasm_fmi3GetFMUState));
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    ENTER("fmi3FreeFMUState")
    LEAVE(plant_handle(p, state, wasm_fmi3FreeFMUState));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    ENTER("fmi3SerializedFMUStateSize")
    LEAVE(plant_size(p, plant_state(p, state), size, wasm_fmi3SerializedFMUStateSize));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    ENTER("fmi3SerializeFMUState")
    LEAVE(plant_serialize(p, plant_state(p, state), bytes, size, wasm_fmi3SerializeFMUState));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    ENTER("fmi3DeserializeFMUState")
    LEAVE(plant_deserialize(p, bytes, size, state, wasm_fmi3DeserializeFMUState));
}

/* Derivatives. */
#define DERIVATIVES(name)                                                                                               \
    fmi3Status name(fmi3Instance c, const fmi3ValueReference unknowns[], size_t number_of_unknowns,                     \
                    const fmi3ValueReference knowns[], size_t number_of_knowns, const fmi3Float64 seeds[],              \
                    size_t number_of_seeds, fmi3Float64 sensitivities[], size_t number_of_sensitivities) {              \
        ENTER(#name)                                                                                                    \
        plant_reserve(p, PLANT_BYTES(number_of_unknowns, 4) + PLANT_BYTES(number_of_knowns, 4) +                        \
                             PLANT_BYTES(number_of_seeds, 8) + PLANT_BYTES(number_of_sensitivities, 8));                \
        {                                                                                                               \
            u32 of = plant_take(p, unknowns, number_of_unknowns, 4), by = plant_take(p, knowns, number_of_knowns, 4);   \
            u32 seed = plant_take(p, seeds, number_of_seeds, 8);                                                        \
            u32 values = plant_take(p, sensitivities, number_of_sensitivities, 8);                                      \
            u32 status = wasm_##name(S, C, of, COUNT(number_of_unknowns), by, COUNT(number_of_knowns), seed,            \
                                     COUNT(number_of_seeds), values, COUNT(number_of_sensitivities));                   \
            plant_give(p, values, sensitivities, number_of_sensitivities, 8);                                           \
            LEAVE(status);                                                                                              \
        }                                                                                                               \
    }
DERIVATIVES(fmi3GetDirectionalDerivative)
DERIVATIVES(fmi3GetAdjointDerivative)

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Int32 orders[],
                                    fmi3Float64 value[], size_t room) {
    ENTER("fmi3GetOutputDerivatives")
    plant_reserve(p, PLANT_BYTES(nvr, 8) + PLANT_BYTES(room, 8) + 32);
    {
        u32 references = plant_take(p, vr, nvr, 4), order = plant_take(p, orders, nvr, 4);
        u32 values = plant_take(p, value, room, 8);
        u32 status = wasm_fmi3GetOutputDerivatives(S, C, references, COUNT(nvr), order, values, COUNT(room));
        plant_give(p, values, value, room, 8);
        LEAVE(status);
    }
}

/* Vectors of a solver outside. */
#define VECTOR(name, of)                                                   \
    fmi3Status name(fmi3Instance c, of fmi3Float64 value[], size_t number) { \
        ENTER(#name)                                                       \
        plant_reserve(p, PLANT_BYTES(number, 8));                          \
        {                                                                  \
            u32 values = plant_take(p, value, number, 8);                  \
            u32 status = wasm_##name(S, C, values, COUNT(number));         \
            GIVE(values, value, number, 8)                                 \
            LEAVE(status);                                                 \
        }                                                                  \
    }
VECTOR(fmi3SetContinuousStates, const)
#undef GIVE
#define GIVE(from, to, number, size) plant_give(p, from, to, number, size);
VECTOR(fmi3GetContinuousStateDerivatives, )
VECTOR(fmi3GetEventIndicators, )
VECTOR(fmi3GetContinuousStates, )
VECTOR(fmi3GetNominalsOfContinuousStates, )

#define NUMBER(name)                                                   \
    fmi3Status name(fmi3Instance c, size_t *number) {                  \
        u32 told, length = 0, status;                                  \
        ENTER(#name)                                                   \
        plant_reserve(p, PLANT_BYTES(1u, 4));                          \
        told = plant_take(p, number ? &length : NULL, 1, 4);           \
        status = wasm_##name(S, C, told);                              \
        plant_give(p, told, number ? &length : NULL, 1, 4);            \
        if (number && status == PLANT_OK) *number = length;            \
        LEAVE(status);                                                 \
    }
NUMBER(fmi3GetNumberOfEventIndicators)
NUMBER(fmi3GetNumberOfContinuousStates)

/* Steps and events. */
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean is_final, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    ENTER("fmi3DoStep")
    plant_reserve(p, 3 * PLANT_BYTES(1u, 1) + PLANT_BYTES(1u, 8));
    {
        u32 needs_event = plant_take(p, event, 1, 1), ends = plant_take(p, end, 1, 1), is_early = plant_take(p, early, 1, 1);
        u32 until = plant_take(p, last, 1, 8);
        u32 status = wasm_fmi3DoStep(S, C, time, step, is_final, needs_event, ends, is_early, until);
        plant_give(p, needs_event, event, 1, 1);
        plant_give(p, ends, end, 1, 1);
        plant_give(p, is_early, early, 1, 1);
        plant_give(p, until, last, 1, 8);
        LEAVE(status);
    }
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean is_final, fmi3Boolean *event, fmi3Boolean *end) {
    ENTER("fmi3CompletedIntegratorStep")
    plant_reserve(p, 2 * PLANT_BYTES(1u, 1));
    {
        u32 needs_event = plant_take(p, event, 1, 1), ends = plant_take(p, end, 1, 1);
        u32 status = wasm_fmi3CompletedIntegratorStep(S, C, is_final, needs_event, ends);
        plant_give(p, needs_event, event, 1, 1);
        plant_give(p, ends, end, 1, 1);
        LEAVE(status);
    }
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needed, fmi3Boolean *end, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *is_defined, fmi3Float64 *next) {
    ENTER("fmi3UpdateDiscreteStates")
    plant_reserve(p, 5 * PLANT_BYTES(1u, 1) + PLANT_BYTES(1u, 8));
    {
        fmi3Boolean *flags[5];
        u32 told[5], time = plant_take(p, next, 1, 8), status;
        int place;
        flags[0] = needed, flags[1] = end, flags[2] = nominals, flags[3] = values, flags[4] = is_defined;
        for (place = 0; place < 5; place++) told[place] = plant_take(p, flags[place], 1, 1);
        status = wasm_fmi3UpdateDiscreteStates(S, C, told[0], told[1], told[2], told[3], told[4], time);
        for (place = 0; place < 5; place++) plant_give(p, told[place], flags[place], 1, 1);
        plant_give(p, time, next, 1, 8);
        LEAVE(status);
    }
}
