/* Instances of the module and their memory; how calls of the host get into one and out again. */
#include "plant.h"

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

#ifdef host_panic
void host_panic(Module *s, u32 text) { ((Plant *)s)->cause = text_at((Plant *)s, text); }
#endif

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
#ifdef wasm_plant_begin
    wasm_plant_begin(&plant->module);
#endif
    return plant;
}

void plant_tell(Plant *plant, int status, const char *category, const char *text, const char *more) {
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
int plant_passes(Plant *plant, u64 fingerprint) {
    if (fingerprint == MODEL_FINGERPRINT) return 1;
    plant_tell(plant, PLANT_SELF_TEST > 1 ? PLANT_ERROR : PLANT_WARNING,
         PLANT_SELF_TEST > 1 ? "logStatusError" : "logStatusWarning",
         "the self-test does not give the bits that it gives elsewhere: numbers are not computed exactly as in IEEE 754. ",
         "Leave out compiler options such as -ffast-math, and look for contracted or extended precision");
    return PLANT_SELF_TEST < 2;
}
#endif

Plant *plant_ready(Plant *plant, u32 component) {
    int is_ready = component != 0;
#if PLANT_SELF_TEST && defined(wasm_plant_self_test)
    is_ready = is_ready && plant_passes(plant, wasm_plant_self_test(&plant->module));
#endif
    if (!is_ready) {
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
    /* A call during another one, also from the logger, is refused; the logger itself may be running. */
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
    plant_tell(plant, PLANT_FATAL, "logStatusFatal", "internal error: ", cause_of(plant));
    return plant_leave(plant, PLANT_FATAL);
}
