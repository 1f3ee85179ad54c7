/* Instances of the module and their memory; how calls of the host get into one and out again. */
#include "plant.h"

/* Whether the self-test is left out (0), its failure is a warning (1) or an error (2). */
#ifndef PLANT_SELF_TEST
#define PLANT_SELF_TEST 1
#endif

#ifndef PLANT_INSTANCES
#include <stdlib.h>
#endif

/* A flag that is taken by one thread at most. */
#if defined(__GNUC__) || defined(__clang__)
#define TAKE_FLAG(flag) __atomic_exchange_n(flag, 1, __ATOMIC_ACQUIRE)
#define DROP_FLAG(flag) __atomic_store_n(flag, 0, __ATOMIC_RELEASE)
#elif defined(_MSC_VER)
#include <intrin.h>
#define TAKE_FLAG(flag) _InterlockedExchange8(flag, 1)
#define DROP_FLAG(flag) _InterlockedExchange8(flag, 0)
#else
static char take_flag(char *flag) {
    char old = *flag;
    *flag = 1;
    return old;
}
#define TAKE_FLAG(flag) take_flag(flag)
#define DROP_FLAG(flag) (*(flag) = 0)
#endif

#ifdef PLANT_INSTANCES
#if PLANT_INSTANCES < 1
#error "PLANT_INSTANCES is how many instances there is room for: 1 or more. Leave it out to have them allocated"
#endif
/* Memory of a size that is known when this is compiled. */
static Plant pool[PLANT_INSTANCES];
static char is_taken[PLANT_INSTANCES];

static Plant *new_plant(void) {
    int place;
    for (place = 0; place < PLANT_INSTANCES; place++) {
        if (!TAKE_FLAG(&is_taken[place])) {
            memset(&pool[place], 0, sizeof pool[place]);
            return &pool[place];
        }
    }
    return NULL;
}

void plant_release(Plant *plant) { DROP_FLAG(&is_taken[plant - pool]); }
#else
static Plant *new_plant(void) { return (Plant *)calloc(1, sizeof(Plant)); }
void plant_release(Plant *plant) { free(plant); }
#endif

/* What the module asks of its host. */

/* A text of the module's; one that does not end within its memory is none. */
static const char *text_at(Plant *plant, u32 address) {
    const u8 *text = plant->module.memory + address;
    return address && address < MEMORY && memchr(text, 0, MEMORY - address) ? (const char *)text : NULL;
}

void host_log(Module *s, u32 status, u32 category, u32 text) {
    Plant *plant = (Plant *)s;
    const char *of = text_at(plant, category), *message = text_at(plant, text);
    if (plant->sink && of && message) plant->sink(plant, (int)status, of, message);
}

void host_panic(Module *s, u32 text) { ((Plant *)s)->cause = text_at((Plant *)s, text); }

u32 module_grow(Module *s, u32 pages) {
    u32 before = s->pages;
    if (pages > MEMORY / PAGE - before) return 0xffffffffu;
    s->pages += pages;
    return before;
}

void module_trap(Module *s, int why) {
    ((Plant *)s)->trap = why;
    longjmp(s->jump, why);
}

/* Life of a plant. */

Plant *plant_new(const char *function, const char *name, PlantSink *sink, void (*logger)(void), void *environment) {
    Plant *plant = new_plant();
    if (!plant) return NULL;
    plant->module.memory = (u8 *)plant->memory;
    plant->module.pages = MODULE_PAGES;
    plant->function = function;
    if (name) strncpy(plant->name, name, sizeof plant->name - 1);
    plant->sink = sink;
    plant->logger = logger;
    plant->environment = environment;
    plant->busy = 1;
    module_start(&plant->module);
    wasm_plant_begin(&plant->module);
    return plant;
}

/* A message that begins with the function. */
static void tell(Plant *plant, int status, const char *category, const char *text, const char *more) {
    char message[512];
    const char *parts[4];
    size_t length = 0, part;
    parts[0] = plant->function, parts[1] = ": ", parts[2] = text, parts[3] = more;
    for (part = 0; part < 4; part++) {
        const char *next = parts[part];
        for (; *next && length < sizeof message - 2; next++) {
            message[length++] = *next;
            if (*next == '%' && plant->logs_formats) message[length++] = '%';
        }
    }
    message[length] = 0;
    if (plant->sink) plant->sink(plant, status, category, message);
}

#if PLANT_SELF_TEST
static int passes_self_test(Plant *plant) {
    if (wasm_plant_self_test(&plant->module) == MODEL_FINGERPRINT) return 1;
    tell(plant, PLANT_SELF_TEST > 1 ? PLANT_ERROR : PLANT_WARNING,
         PLANT_SELF_TEST > 1 ? "logStatusError" : "logStatusWarning",
         "the self-test does not give the bits that it gives elsewhere: numbers are not computed exactly as in IEEE 754. ",
         "Leave out compiler options such as -ffast-math, and look for contracted or extended precision");
    return PLANT_SELF_TEST < 2;
}
#else
#define passes_self_test(plant) 1
#endif

Plant *plant_ready(Plant *plant, u32 component) {
    if (!component || !passes_self_test(plant)) {
        plant_release(plant);
        return NULL;
    }
    plant->component = component;
    DROP_FLAG(&plant->busy);
    return plant;
}

/* Calls. A trap comes back to where the call began, by setjmp there. */

int plant_enter(void *instance, const char *function) {
    Plant *plant = (Plant *)instance;
    if (!plant || (uintptr_t)instance % sizeof(void *)) return PLANT_ERROR;
    /* A call during another one, also from the logger, is refused; the logger may be just what is running. */
    if (TAKE_FLAG(&plant->busy)) return PLANT_ERROR;
    plant->function = function;
    return plant->is_lost ? plant_lost(plant) : PLANT_OK;
}

int plant_leave(Plant *plant, u32 status) {
    DROP_FLAG(&plant->busy);
    return (int)status;
}

static const char *cause_of(const Plant *plant) {
    if (plant->cause) return plant->cause;
    switch (plant->trap) {
        case UNREACHABLE: return "the instance has no memory left; compile the sources with a larger PLANT_HEAP";
        case OUT_OF_BOUNDS: return "the memory of the instance was overwritten, or its stack has overflowed";
        default: return "the memory of the instance was overwritten";
    }
}

int plant_lost(Plant *plant) {
    plant->is_lost = 1;
    tell(plant, PLANT_FATAL, "logStatusFatal", "internal error: ", cause_of(plant));
    return plant_leave(plant, PLANT_FATAL);
}

/* Arrays. The module reads and writes copies, in little-endian order like all of its memory. */

void plant_reserve(Plant *plant, u64 bytes) {
    plant->room = bytes > MEMORY ? 0 : wasm_plant_room(&plant->module, (u32)bytes);
    /* A module whose memory was overwritten may say anything. */
    if (plant->room > MEMORY || (plant->room && bytes > MEMORY - plant->room)) module_trap(&plant->module, OUT_OF_BOUNDS);
}

static void copy_elements(u8 *to, const u8 *from, size_t number, unsigned size) {
#ifdef BIG_ENDIAN_HOST
    size_t element;
    unsigned byte;
    for (element = 0; element < number; element++) {
        for (byte = 0; byte < size; byte++) to[element * size + byte] = from[element * size + size - 1 - byte];
    }
#else
    memcpy(to, from, number * size);
#endif
}

u32 plant_take(Plant *plant, const void *array, size_t number, unsigned size) {
    unsigned alignment = size < sizeof(void *) ? size : (unsigned)sizeof(void *);
    u32 is_misaligned = (uintptr_t)array % alignment != 0, address;
    if (!array) return 0;
    /* As badly aligned as the host's, which the module refuses. */
    address = (plant->room + 7u) / 8u * 8u + is_misaligned;
    if (plant->room) {
        if (number) copy_elements(plant->module.memory + address, (const u8 *)array, number, size);
        plant->room = address + (u32)number * size;
    }
    return plant->room ? address : 8u + is_misaligned;
}

void plant_give(Plant *plant, u32 address, void *array, size_t number, unsigned size) {
    if (array && plant->room && number) copy_elements((u8 *)array, plant->module.memory + address, number, size);
}

u32 plant_text(Plant *plant, const char *text) { return text ? plant_take(plant, text, strlen(text) + 1, 1) : 0; }

u32 plant_texts(Plant *plant, const char *const texts[], size_t number) {
    u64 bytes = PLANT_BYTES(number, 4);
    u32 list;
    size_t place;
    for (place = 0; texts && bytes <= MEMORY && place < number; place++) bytes += PLANT_TEXT(texts[place]);
    plant_reserve(plant, bytes);
    /* The addresses are written over the copies of the host's. */
    list = plant_take(plant, texts, number, 4);
    for (place = 0; texts && plant->room && place < number; place++) {
        u32 address = plant_text(plant, texts[place]);
        siu(plant->module.memory, list + 4u * (u32)place, 0, address);
    }
    return list;
}

/* A saved state is known to the host by where it is in the memory of its instance. */
u32 plant_state(const Plant *plant, const void *state) {
    uintptr_t place = (uintptr_t)state - (uintptr_t)plant->module.memory;
    return !state ? 0 : place < MEMORY ? (u32)place : 0xffffffffu;
}

static void *state_of(Plant *plant, u32 handle) { return handle ? plant->module.memory + handle : NULL; }

u32 plant_handle(Plant *plant, void **state, u32 call(Module *, u32, u32)) {
    u32 handle = state ? plant_state(plant, *state) : 0, told, status;
    plant_reserve(plant, PLANT_BYTES(1u, 4));
    told = plant_take(plant, state ? &handle : NULL, 1, 4);
    status = call(&plant->module, plant->component, told);
    plant_give(plant, told, state ? &handle : NULL, 1, 4);
    if (state && status == PLANT_OK) *state = state_of(plant, handle);
    return status;
}

u32 plant_size(Plant *plant, u32 argument, size_t *size, u32 call(Module *, u32, u32, u32)) {
    u32 number = 0, told, status;
    plant_reserve(plant, PLANT_BYTES(1u, 4));
    told = plant_take(plant, size ? &number : NULL, 1, 4);
    status = call(&plant->module, plant->component, argument, told);
    plant_give(plant, told, size ? &number : NULL, 1, 4);
    if (size && status == PLANT_OK) *size = number;
    return status;
}

u32 plant_serialize(Plant *plant, u32 state, void *bytes, size_t size, u32 call(Module *, u32, u32, u32, u32)) {
    u32 copies, status;
    plant_reserve(plant, PLANT_BYTES(size, 1));
    copies = plant_take(plant, bytes, size, 1);
    status = call(&plant->module, plant->component, state, copies, PLANT_COUNT(plant, size));
    plant_give(plant, copies, bytes, size, 1);
    return status;
}

u32 plant_deserialize(Plant *plant, const void *bytes, size_t size, void **state, u32 call(Module *, u32, u32, u32, u32)) {
    u32 handle = 0, copies, told, status;
    plant_reserve(plant, PLANT_BYTES(size, 1) + PLANT_BYTES(1u, 4));
    copies = plant_take(plant, bytes, size, 1);
    told = plant_take(plant, state ? &handle : NULL, 1, 4);
    status = call(&plant->module, plant->component, copies, PLANT_COUNT(plant, size), told);
    plant_give(plant, told, state ? &handle : NULL, 1, 4);
    if (state && status == PLANT_OK) *state = state_of(plant, handle);
    return status;
}
