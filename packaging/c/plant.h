/* What the functions of FMI and the loop have in common: instances, calls, and the host's arrays. */
#ifndef PLANT_H
#define PLANT_H

#include "code.h"
#include "loop.h"

#define plant_new PLANT_NAME(plant_new)
#define plant_release PLANT_NAME(plant_release)
#define plant_ready PLANT_NAME(plant_ready)
#define plant_enter PLANT_NAME(plant_enter)
#define plant_leave PLANT_NAME(plant_leave)
#define plant_lost PLANT_NAME(plant_lost)
#define plant_tell PLANT_NAME(plant_tell)
#define plant_passes PLANT_NAME(plant_passes)
#define plant_reserve PLANT_NAME(plant_reserve)
#define plant_take PLANT_NAME(plant_take)
#define plant_give PLANT_NAME(plant_give)
#define plant_text PLANT_NAME(plant_text)
#define plant_texts PLANT_NAME(plant_texts)
#define plant_state PLANT_NAME(plant_state)
#define plant_handle PLANT_NAME(plant_handle)
#define plant_size PLANT_NAME(plant_size)
#define plant_serialize PLANT_NAME(plant_serialize)
#define plant_deserialize PLANT_NAME(plant_deserialize)

/* Whether the self-test is left out (0), its failure is a warning (1) or an error (2). */
#ifndef PLANT_SELF_TEST
#define PLANT_SELF_TEST 1
#endif

/* Takes a message to the host: status, category and text. */
typedef void PlantSink(Plant *plant, int status, const char *category, const char *text);

struct Plant {
    /* First member: the module passes its own address to the host, which is the plant's. */
    Module module;
    /* The instance in the module's memory. */
    u32 component;
    /* Whether a call is being carried out. */
    char busy;
    char is_lost;
    char is_started;
    /* Whether the host's logger takes a text as a format of printf. */
    char logs_formats;
    /* Why the module could not go on. */
    int trap;
    /* The call that is carried out, and the message of a panic. */
    const char *function;
    const char *cause;
    /* The name of the instance, as far as it fits. */
    char name[64];
    /* Where the next of the host's arrays goes; 0 if they do not fit. */
    u32 room;
    double time;
    /* Where the values of the loop are, and whether the computed ones belong to the present inputs. */
    u32 values;
    char is_computed;
    /* The host's logger, of a type that the sink knows. */
    PlantSink *sink;
    void (*logger)(void);
    void *environment;
    u64 memory[(MEMORY + MARGIN) / 8];
};

/* A plant without an instance; NULL if there is no memory. */
Plant *plant_new(const char *function, const char *name, PlantSink *sink, void (*logger)(void), void *environment);
void plant_release(Plant *plant);
/* The plant with an instance that was made, once the self-test is done; NULL, without the plant, if there is none. */
Plant *plant_ready(Plant *plant, u32 component);
/* Begins a call of the host; returns its status, or 0 if it may go on. */
int plant_enter(void *instance, const char *function);
int plant_leave(Plant *plant, u32 status);
/* Ends a call that was trapped. */
int plant_lost(Plant *plant);
/* Hands a message to the host, which begins with the function; `more` is put behind the text. */
void plant_tell(Plant *plant, int status, const char *category, const char *text, const char *more);
/* Whether the self-test has passed, or its failure is a warning. */
int plant_passes(Plant *plant, u64 fingerprint);

/* Memory for arrays of this size together, by PLANT_BYTES. */
void plant_reserve(Plant *plant, u64 bytes);
/* Copies an array of the host into the room and returns its address there. */
u32 plant_take(Plant *plant, const void *array, size_t number, unsigned size);
/* Copies it back. */
void plant_give(Plant *plant, u32 address, void *array, size_t number, unsigned size);
/* The address of a copy of a string in the room. */
u32 plant_text(Plant *plant, const char *text);
/* Reserves room for strings, and returns the address of an array of their addresses. */
u32 plant_texts(Plant *plant, const char *const texts[], size_t number);

/* The handle in the module of a saved state; one of another instance is none there. */
u32 plant_state(const Plant *plant, const void *state);

/* Calls that the versions have in common: saving or forgetting a state, a size that is told, a state as bytes. */
u32 plant_handle(Plant *plant, void **state, u32 call(Module *, u32, u32));
u32 plant_size(Plant *plant, u32 argument, size_t *size, u32 call(Module *, u32, u32, u32));
u32 plant_serialize(Plant *plant, u32 state, void *bytes, size_t size, u32 call(Module *, u32, u32, u32, u32));
u32 plant_deserialize(Plant *plant, const void *bytes, size_t size, void **state, u32 call(Module *, u32, u32, u32, u32));

/* What model.c has for the loop: the slots of the outputs, both structures as values, and the inputs of the self-test. */
#define plant_output_slots PLANT_NAME(plant_output_slots)
#define plant_inputs_of PLANT_NAME(plant_inputs_of)
#define plant_outputs_of PLANT_NAME(plant_outputs_of)
#define plant_test_step PLANT_NAME(plant_test_step)
#define plant_test_steps PLANT_NAME(plant_test_steps)
#define plant_test_inputs PLANT_NAME(plant_test_inputs)
extern const uint16_t plant_output_slots[];
void plant_inputs_of(const PlantInputs *inputs, double *values);
void plant_outputs_of(const double *values, PlantOutputs *outputs);
extern const double plant_test_step;
extern const unsigned plant_test_steps;
extern const double plant_test_inputs[];

/* Begins a call of a function of FMI: from here a trap comes back. */
#define PLANT_ENTER(plant, instance, function, status)                   \
    Plant *plant = (Plant *)(instance);                                  \
    {                                                                    \
        int refused = plant_enter(instance, function);                   \
        if (refused) return (status)refused;                             \
        if (setjmp(plant->module.jump)) return (status)plant_lost(plant); \
    }

/* Largest size of an array with its alignment; an impossible size is far too large. */
#define PLANT_BYTES(number, size) ((number) > 0x7fffffffu ? 0xffffffffull : (u64)(number) * (size) + 16u)
#define PLANT_TEXT(text) ((text) != NULL ? PLANT_BYTES(strlen(text) + 1, 1) : 0u)
/* A number of elements as the module has it: more than there can be if they do not fit. */
#define PLANT_COUNT(plant, number) ((number) == 0 ? 0u : (plant)->room == 0 || (number) > 0xffffffffu ? 0xffffffffu : (u32)(number))

#endif
