/* Prints a hash of what each operation in floating-point numbers gives of many pairs, whose exponents differ by all that
   matters, and whose digits are random, few, or all set. */
#include <inttypes.h>
#include <stdio.h>

#include "code.h"

enum { PAIRS = 2000, FARTHEST = 60 };

static u64 state;

static u64 random_bits(void) {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return state * 0x2545f4914f6cdd1dull;
}

/* The last 52 bits of a number: what rounds is found where they are few, or end in ones. */
static u64 digits(void) {
    u64 all = random_bits() >> 12, cut = ((u64)1 << random_bits() % 53) - 1;
    switch (random_bits() % 4) {
        case 0: return all;
        case 1: return all & ~cut;
        case 2: return (cut + 1) >> 1 | (all & 1);
        default: return cut ^ (all & cut >> 1);
    }
}

static f64 number(u64 exponent) { return of_bits64(random_bits() << 63 | exponent << 52 | digits()); }
static f32 single(u32 exponent) { return of_bits32((u32)random_bits() << 31 | exponent << 23 | (u32)(digits() >> 29)); }

static u64 hash;

static void take(u64 bits) {
    int byte;
    for (byte = 0; byte < 8; byte++) hash = (hash ^ (bits >> (8 * byte) & 255)) * 0x100000001b3ull;
}

static void begin(void) {
    state = 1;
    hash = 0xcbf29ce484222325ull;
}

static void show(const char *name) {
    printf("%s %08" PRIx32 "%08" PRIx32 "\n", name, (u32)(hash >> 32), (u32)hash);
}

/* Of all pairs, once in each precision. */
#define PAIRWISE(name, expression, single_expression)                              \
    begin();                                                                       \
    for (distance = -FARTHEST; distance <= FARTHEST; distance++) {                 \
        for (pair = 0; pair < PAIRS; pair++) {                                     \
            u64 exponent = 1000 + random_bits() % 50;                              \
            f64 a = number(exponent), b = number(exponent + (u64)(s64)distance);   \
            take(bits64(expression));                                              \
        }                                                                          \
    }                                                                              \
    show(name);                                                                    \
    begin();                                                                       \
    for (distance = -FARTHEST / 2; distance <= FARTHEST / 2; distance++) {         \
        for (pair = 0; pair < PAIRS; pair++) {                                     \
            u32 exponent = 100 + (u32)(random_bits() % 50);                        \
            f32 a = single(exponent), b = single(exponent + (u32)distance);        \
            take(bits32(single_expression));                                       \
        }                                                                          \
    }                                                                              \
    show("single " name);

/* At both ends of what is represented. */
static void ends(void) {
    static const u64 at[] = {0, 1, 0xfffffffffffffull, 0x10000000000000ull,
                             0x7fe0000000000000ull, 0x7fefffffffffffffull, 0x7ff0000000000000ull};
    int pair;
    size_t one, other;
    begin();
    for (pair = 0; pair < 30 * PAIRS; pair++) {
        u64 exponent = random_bits() % 60, high = 2046 - exponent % 3;
        f64 a = number(exponent), b = number(random_bits() % 60), c = number(high), d = number(2044 + random_bits() % 3);
        take(bits64(add64(a, b))), take(bits64(sub64(a, b)));
        take(bits64(add64(c, d))), take(bits64(sub64(c, d)));
        take(bits64(a * number(1000))), take(bits64(a / number(1040)));
    }
    for (one = 0; one < sizeof at / sizeof *at; one++) {
        for (other = 0; other < sizeof at / sizeof *at; other++) {
            f64 sums[4], a = of_bits64(at[one]), b = of_bits64(at[other]);
            sums[0] = add64(a, b), sums[1] = sub64(a, b), sums[2] = add64(-a, b), sums[3] = sub64(-a, b);
            /* What is no number has no defined bits. */
            for (pair = 0; pair < 4; pair++) take(sums[pair] == sums[pair] ? bits64(sums[pair]) : 1);
        }
    }
    show("ends");
}

static void rounded(void) {
    int pair;
    begin();
    for (pair = 0; pair < 50 * PAIRS; pair++) {
        f64 a = number(1000 + random_bits() % 80);
        take(bits64(floor(a))), take(bits64(ceil(a))), take(bits64(trunc(a))), take(bits64(rint(a)));
        take(bits64(sqrt(fabs(number(random_bits() % 2047)))));
        take(sat32s(a)), take(sat32(a)), take(sat64s(a)), take(sat64(a));
    }
    show("rounded");
}

static void converted(void) {
    int pair;
    begin();
    for (pair = 0; pair < 50 * PAIRS; pair++) {
        u64 a = random_bits() >> random_bits() % 64;
        take(bits64((f64)a)), take(bits64((f64)(s64)a)), take(bits64((f64)(u32)a)), take(bits64((f64)(s32)a));
        take(bits32((f32)a)), take(bits32((f32)(s64)a)), take(bits32((f32)number(860 + random_bits() % 300)));
        take(bits64((f64)single((u32)(random_bits() % 255))));
    }
    show("converted");
}

int main(void) {
    int distance, pair;
    PAIRWISE("sums", add64(a, b), a + b)
    PAIRWISE("differences", sub64(a, b), a - b)
    PAIRWISE("products", a * b, a * b)
    PAIRWISE("quotients", a / b, a / b)
    ends();
    rounded();
    converted();
    return 0;
}
