/* The types of a translated module, and floating-point numbers as they are written. */
#ifndef WASM_H
#define WASM_H

#include <math.h>
#include <setjmp.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* A product and a sum must not be contracted into one operation, whose last digit differs. In C99 that is said by the
   first pragma; GCC does not know it, and contracts unless it is told by the second. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#pragma float_control(precise, on)
#else
#pragma STDC FP_CONTRACT OFF
#endif

#if defined(__FAST_MATH__)
#error "The module is not computed exactly with -ffast-math or -Ofast: leave that out"
#endif

typedef uint8_t u8;
typedef int8_t s8;
typedef uint16_t u16;
typedef int16_t s16;
typedef uint32_t u32;
typedef int32_t s32;
typedef uint64_t u64;
typedef int64_t s64;
typedef float f32;
typedef double f64;

/* Double precision is what everything rests on. */
typedef char f64_is_double_precision[sizeof(f64) == 8 ? 1 : -1];

/* Bytes of memory of an instance: what the module starts with, unless there is more. Where the module takes pages into use, it is
   whole pages. */
#ifndef MEMORY
#define MEMORY MODULE_BYTES
#endif

typedef void (*Function)(void);

/* Why the module cannot go on. */
enum {
    UNREACHABLE = 1,
    OUT_OF_BOUNDS,
    CALL_INDIRECT,
    DIVIDE_BY_ZERO,
    INTEGER_OVERFLOW
};

/* An instance of the module. */
typedef struct Module {
    /* MEMORY, a MARGIN behind it that nothing uses, and how many pages of the first are in use. */
    u8 *memory;
    u32 pages;
    MODULE_GLOBALS
    /* Where a trap leads. */
    jmp_buf jump;
} Module;

#endif
