/* Loads and stores in the order of bytes that all targets share, at even and odd addresses, and up to the bounds of an
   instance's memory: what is beyond them traps. */
#include <inttypes.h>
#include <stdio.h>

#include "loop.h"
#include "plant.h"

static void show(const char *text) { puts(text); }

/* Whether a load of eight bytes traps. */
static int traps(Module *s, u32 address, u32 offset) {
    volatile u64 value;
    within(address, offset + 8);
    value = lju(s->memory, address, offset);
    return (void)value, 0;
X:
    return 1;
}

/* Whether a store of eight bytes does. */
static int traps_on_store(Module *s, u32 address, u32 offset) {
    within(address, offset + 8);
    sju(s->memory, address, offset, 0);
    return 0;
X:
    return 1;
}

static int bounds(Module *s) {
    static const struct {
        u32 address, offset;
        int traps;
    } accesses[] = {
        {MEMORY - 8, 0, 0},
        {MEMORY, 0, 1},
        {MEMORY + 1, MARGIN - 8, 1},
        {0xfffffff8u, 0, 1},
        {0xffffffffu, 16, 1},
        /* In the margin, which belongs to nothing. */
        {MEMORY - 1, MARGIN - 8, 0},
        /* Offsets that are larger than the margin. */
        {MEMORY - 8 - 2 * MARGIN, 2 * MARGIN, 0},
        {MEMORY - 7 - 2 * MARGIN, 2 * MARGIN, 1},
        {0, MEMORY - 8, 0},
        {1, MEMORY - 8, 1},
        {0xffffffffu, MEMORY - 8, 1},
    };
    size_t place;
    int wrong = 0;
    for (place = 0; place < sizeof accesses / sizeof *accesses; place++) {
        u32 address = accesses[place].address, offset = accesses[place].offset;
        wrong += traps(s, address, offset) != accesses[place].traps;
        wrong += traps_on_store(s, address, offset) != accesses[place].traps;
    }
    return wrong;
}

static u32 sum_of_bytes(Module *s, u32 address) {
    u32 sum = 0, place;
    for (place = 0; place < 8; place++) sum = 31 * sum + li1(s->memory, address, place);
    return sum;
}

int main(void) {
    Plant *plant = plant_init(show);
    Module *s;
    u32 address;
    int wrong;
    if (!plant) return 1;
    s = &plant->module;
    /* Where the heap ends, so that nothing of the plant's is overwritten. */
    for (address = MEMORY - 128; address < MEMORY - 112; address++) {
        sju(s->memory, address, 0, 0x8182838485868788ull);
        printf("%" PRIu32 " %" PRIx32, address % 8, sum_of_bytes(s, address));
        sdu(s->memory, address, 0, -0.1);
        printf(" %" PRIx32, sum_of_bytes(s, address));
        siu(s->memory, address, 4, 0x91929394u);
        si2u(s->memory, address, 1, 0xa1a2u);
        printf(" %" PRIx32 " %d", sum_of_bytes(s, address), lju(s->memory, address, 0) == bits64(ldu(s->memory, address, 0)));
        printf(" %" PRIx32 " %" PRIx32 "\n", li2su(s->memory, address, 1), li1s(s->memory, address, 5));
    }
    sj(s->memory, MEMORY - 64, 8, 0x8182838485868788ull);
    wrong = lj(s->memory, MEMORY - 64, 8) != 0x8182838485868788ull || li(s->memory, MEMORY - 64, 12) != 0x81828384u;
    wrong += lj4s(s->memory, MEMORY - 64, 12) != 0xffffffff81828384ull || li2(s->memory, MEMORY - 64, 8) != 0x8788u;
    wrong += bounds(s);
    printf("memory: %d wrong\n", wrong);
    plant_free(plant);
    return wrong;
}
