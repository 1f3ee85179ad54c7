/* Arrays, texts and saved states that the functions of FMI copy into an instance's memory and out of it. */
#include "plant.h"

/* The module reads and writes copies, in little-endian order like all of its memory. */

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
