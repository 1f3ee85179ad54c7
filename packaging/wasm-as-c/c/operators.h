/* The operators of WebAssembly that C does not have, and memory in little-endian order with its bounds checked. */
#ifndef OPERATORS_H
#define OPERATORS_H

#if defined(__GNUC__) || defined(__clang__)
#define INLINE static inline __attribute__((always_inline, unused))
#define NO_RETURN __attribute__((noreturn, cold))
#define UNLIKELY(x) __builtin_expect(!!(x), 0)
#elif defined(_MSC_VER)
#define INLINE static __forceinline
#define NO_RETURN __declspec(noreturn)
#define UNLIKELY(x) (x)
#pragma warning(disable : 4102 4146 4189 4101 4505)
#else
#define INLINE static inline
#define NO_RETURN
#define UNLIKELY(x) (x)
#endif
#if defined(__GNUC__) && !defined(__clang__)
/* Variables and arguments that hold what nobody takes. */
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#elif defined(__clang__)
#pragma clang diagnostic ignored "-Wunused-parameter"
#pragma clang diagnostic ignored "-Wunused-but-set-variable"
/* Parentheses around whole conditions. */
#pragma clang diagnostic ignored "-Wparentheses-equality"
#endif

/* Memory and global variables at the start. */
void module_start(Module *s);
/* The function of a signature at a place of the table. */
Function module_entry(Module *s, u32 of, u32 place);
/* Ends the call that is carried out. */
NO_RETURN void module_trap(Module *s, int why);
/* Takes a number of pages into use; returns the number before, or ~0 if there are too few. */
u32 module_grow(Module *s, u32 pages);
/* The sum, computed by integers. */
f64 module_sum64(f64 x, f64 y);

#define trap module_trap
#define entry module_entry
#define grow module_grow
#define sum64 module_sum64

/* Memory. An access is preceded by a comparison of its address with MEMORY, where it leads to the label X if so many bytes are
   not there. Behind MEMORY is a MARGIN that belongs to nothing: what is at a small offset from an address below MEMORY is in one
   of the two, so that one comparison serves all fields of a structure. */
#define within(a, bytes) \
    if (UNLIKELY((bytes) <= MARGIN ? (a) >= MEMORY : (bytes) > MEMORY || (a) > MEMORY - (u32)(bytes))) goto X

/* Numbers as they lie in memory, of which the same bytes may be several kinds. */
#if defined(__GNUC__) || defined(__clang__)
#define IN_MEMORY(of) typedef of __attribute__((may_alias)) of##_there
#else
#define IN_MEMORY(of) typedef of of##_there
#endif
IN_MEMORY(u8);
IN_MEMORY(s8);
IN_MEMORY(u16);
IN_MEMORY(s16);
IN_MEMORY(u32);
IN_MEMORY(s32);
IN_MEMORY(u64);
IN_MEMORY(f32);
IN_MEMORY(f64);

/* Loads and stores by the letter of what is in C, and the bytes and s for a sign where less is in memory. Their addresses have
   the natural alignment, or else their names end in u. They are macros where that is possible: there are so many that compilers
   would take twice as long to put functions in their places. */

#if defined(__BYTE_ORDER__) && defined(__ORDER_BIG_ENDIAN__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
#define BIG_ENDIAN_HOST 1
INLINE u64 bytes_in(const u8 *p, int size) {
    u64 x = 0;
    while (size--) x = x << 8 | p[size];
    return x;
}
INLINE void bytes_out(u8 *p, int size, u64 x) {
    int i;
    for (i = 0; i < size; i++) p[i] = (u8)(x >> (8 * i));
}
#define LOAD(of, in, m, a, o) ((of)(in)bytes_in((m) + (a) + (o), sizeof(in)))
#define STORE(in, m, a, o, x) bytes_out((m) + (a) + (o), sizeof(in), (in)(x))
#define LOADS(name, of, in) \
    INLINE of name##u(const u8 *m, u32 a, u32 o) { return LOAD(of, in, m, a, o); }
#define STORES(name, of, in) \
    INLINE void name##u(u8 *m, u32 a, u32 o, of x) { STORE(in, m, a, o, x); }
#else
#define LOAD(of, in, m, a, o) ((of)*(const in##_there *)(const void *)((m) + (a) + (o)))
#define STORE(in, m, a, o, x) (*(in##_there *)(void *)((m) + (a) + (o)) = (in)(x))
#define LOADS(name, of, in)                        \
    INLINE of name##u(const u8 *m, u32 a, u32 o) { \
        in x;                                      \
        memcpy(&x, m + a + o, sizeof x);           \
        return (of)x;                              \
    }
#define STORES(name, of, in)                             \
    INLINE void name##u(u8 *m, u32 a, u32 o, of y) {     \
        in x = (in)y;                                    \
        memcpy(m + a + o, &x, sizeof x);                 \
    }
#endif

#define li(m, a, o) LOAD(u32, u32, m, a, o)
#define li1(m, a, o) LOAD(u32, u8, m, a, o)
#define li1s(m, a, o) LOAD(u32, s8, m, a, o)
#define li2(m, a, o) LOAD(u32, u16, m, a, o)
#define li2s(m, a, o) LOAD(u32, s16, m, a, o)
#define lj(m, a, o) LOAD(u64, u64, m, a, o)
#define lj1(m, a, o) LOAD(u64, u8, m, a, o)
#define lj1s(m, a, o) LOAD(u64, s8, m, a, o)
#define lj2(m, a, o) LOAD(u64, u16, m, a, o)
#define lj2s(m, a, o) LOAD(u64, s16, m, a, o)
#define lj4(m, a, o) LOAD(u64, u32, m, a, o)
#define lj4s(m, a, o) LOAD(u64, s32, m, a, o)
#define si(m, a, o, x) STORE(u32, m, a, o, x)
#define si1(m, a, o, x) STORE(u8, m, a, o, x)
#define si2(m, a, o, x) STORE(u16, m, a, o, x)
#define sj(m, a, o, x) STORE(u64, m, a, o, x)
#define sj1(m, a, o, x) STORE(u8, m, a, o, x)
#define sj2(m, a, o, x) STORE(u16, m, a, o, x)
#define sj4(m, a, o, x) STORE(u32, m, a, o, x)
LOADS(li, u32, u32)
LOADS(li2, u32, u16)
LOADS(li2s, u32, s16)
LOADS(lj, u64, u64)
LOADS(lj2, u64, u16)
LOADS(lj2s, u64, s16)
LOADS(lj4, u64, u32)
LOADS(lj4s, u64, s32)
STORES(si, u32, u32)
STORES(si2, u32, u16)
STORES(sj, u64, u64)
STORES(sj2, u64, u16)
STORES(sj4, u64, u32)

INLINE u32 bits32(f32 x) {
    u32 y;
    memcpy(&y, &x, sizeof y);
    return y;
}
INLINE u64 bits64(f64 x) {
    u64 y;
    memcpy(&y, &x, sizeof y);
    return y;
}
INLINE f32 of_bits32(u32 x) {
    f32 y;
    memcpy(&y, &x, sizeof y);
    return y;
}
INLINE f64 of_bits64(u64 x) {
    f64 y;
    memcpy(&y, &x, sizeof y);
    return y;
}

#ifdef BIG_ENDIAN_HOST
#define le(m, a, o) of_bits32(li(m, a, o))
#define ld(m, a, o) of_bits64(lj(m, a, o))
#define se(m, a, o, x) si(m, a, o, bits32(x))
#define sd(m, a, o, x) sj(m, a, o, bits64(x))
#else
#define le(m, a, o) LOAD(f32, f32, m, a, o)
#define ld(m, a, o) LOAD(f64, f64, m, a, o)
#define se(m, a, o, x) STORE(f32, m, a, o, x)
#define sd(m, a, o, x) STORE(f64, m, a, o, x)
#endif
#define leu(m, a, o) of_bits32(liu(m, a, o))
#define ldu(m, a, o) of_bits64(lju(m, a, o))
#define seu(m, a, o, x) siu(m, a, o, bits32(x))
#define sdu(m, a, o, x) sju(m, a, o, bits64(x))

INLINE void copy(Module *s, u32 to, u32 from, u32 size) {
    if (size > MEMORY || to > MEMORY - size || from > MEMORY - size) trap(s, OUT_OF_BOUNDS);
    memmove(s->memory + to, s->memory + from, size);
}
INLINE void fill(Module *s, u32 to, u32 byte, u32 size) {
    if (size > MEMORY || to > MEMORY - size) trap(s, OUT_OF_BOUNDS);
    memset(s->memory + to, (int)(byte & 255), size);
}
/* The same where the size is a constant, and addresses have been compared as those of other accesses are. */
#define copy_known(m, to, from, size) memmove((m) + (to), (m) + (from), (size))
#define fill_known(m, to, byte, size) memset((m) + (to), (int)((byte) & 255), (size))

/* Integers. */
INLINE u32 shr32s(u32 a, u32 b) { return (u32)((s32)a >> (b & 31)); }
INLINE u64 shr64s(u64 a, u64 b) { return (u64)((s64)a >> (b & 63)); }
INLINE u32 rotl32(u32 a, u32 b) { return a << (b & 31) | a >> (-b & 31); }
INLINE u32 rotr32(u32 a, u32 b) { return a >> (b & 31) | a << (-b & 31); }
INLINE u64 rotl64(u64 a, u64 b) { return a << (b & 63) | a >> (-b & 63); }
INLINE u64 rotr64(u64 a, u64 b) { return a >> (b & 63) | a << (-b & 63); }

#define DIVISION(name, op, of, as, least)                                  \
    INLINE of name##s(Module *s, of a, of b) {                             \
        if (UNLIKELY(b == 0)) trap(s, DIVIDE_BY_ZERO);                     \
        if (UNLIKELY((as)b == -1)) return overflowing_##op(s, a == least, a); \
        return (of)((as)a op##_OPERATOR (as)b);                            \
    }                                                                      \
    INLINE of name(Module *s, of a, of b) {                                \
        if (UNLIKELY(b == 0)) trap(s, DIVIDE_BY_ZERO);                     \
        return a op##_OPERATOR b;                                          \
    }
#define QUOTIENT_OPERATOR /
#define REMAINDER_OPERATOR %
/* Divided by -1: the least number has no quotient, all have the remainder 0. */
INLINE u64 overflowing_QUOTIENT(Module *s, int is_least, u64 a) {
    if (is_least) trap(s, INTEGER_OVERFLOW);
    return 0 - a;
}
INLINE u64 overflowing_REMAINDER(Module *s, int is_least, u64 a) {
    (void)s, (void)is_least, (void)a;
    return 0;
}
DIVISION(div32, QUOTIENT, u32, s32, 0x80000000u)
DIVISION(div64, QUOTIENT, u64, s64, 0x8000000000000000ull)
DIVISION(rem32, REMAINDER, u32, s32, 0x80000000u)
DIVISION(rem64, REMAINDER, u64, s64, 0x8000000000000000ull)

INLINE u64 popcnt64(u64 x) {
    x -= x >> 1 & 0x5555555555555555ull;
    x = (x & 0x3333333333333333ull) + (x >> 2 & 0x3333333333333333ull);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0full;
    return x * 0x0101010101010101ull >> 56;
}
INLINE u32 popcnt32(u32 x) { return (u32)popcnt64(x); }
#if defined(__GNUC__) || defined(__clang__)
INLINE u64 clz64(u64 x) { return x ? (u64)__builtin_clzll(x) : 64; }
INLINE u64 ctz64(u64 x) { return x ? (u64)__builtin_ctzll(x) : 64; }
INLINE u32 clz32(u32 x) { return x ? (u32)clz64(x) - 32 : 32; }
INLINE u32 ctz32(u32 x) { return x ? (u32)ctz64(x) : 32; }
#else
INLINE u64 clz64(u64 x) {
    x |= x >> 1, x |= x >> 2, x |= x >> 4, x |= x >> 8, x |= x >> 16, x |= x >> 32;
    return popcnt64(~x);
}
INLINE u64 ctz64(u64 x) { return popcnt64(~x & (x - 1)); }
INLINE u32 clz32(u32 x) { return (u32)clz64(x) - 32; }
INLINE u32 ctz32(u32 x) { return x ? (u32)ctz64(x) : 32; }
#endif

/* Sums in double precision. The library of GCC for Arm without hardware for them rounds some to the wrong side where exponents
   differ by 32 or 33. */
#if defined(__arm__) && !(defined(__ARM_FP) && (__ARM_FP & 8))
#define SUMS_BY_INTEGERS
#define add64(a, b) sum64(a, b)
#define sub64(a, b) sum64(a, -(b))
#else
#define add64(a, b) ((a) + (b))
#define sub64(a, b) ((a) - (b))
#endif

/* Floating-point numbers: -0 is less than +0, and what is no number stays none. */
#define EXTREMES(of, min, max, bits, of_bits)                              \
    INLINE of min(of a, of b) {                                            \
        if (UNLIKELY(a != a || b != b)) return a + b;                      \
        return a == b ? of_bits(bits(a) | bits(b)) : a < b ? a : b;        \
    }                                                                      \
    INLINE of max(of a, of b) {                                            \
        if (UNLIKELY(a != a || b != b)) return a + b;                      \
        return a == b ? of_bits(bits(a) & bits(b)) : a > b ? a : b;        \
    }
EXTREMES(f32, min32, max32, bits32, of_bits32)
EXTREMES(f64, min64, max64, bits64, of_bits64)

/* To integers: a number that does not fit traps, or becomes the nearest that does, and what is no number 0. Single precision
   is exact in double precision. */
#define TRUNCATION(trunc, sat, of, as, low, high, least, most)                      \
    INLINE of trunc(Module *s, f64 x) {                                             \
        if (UNLIKELY(!(x > low && x < high))) trap(s, INTEGER_OVERFLOW);            \
        return (of)(as)x;                                                           \
    }                                                                               \
    INLINE of sat(f64 x) { return x > low && x < high ? (of)(as)x : x >= high ? most : x <= low ? least : 0; }
TRUNCATION(trunc32s, sat32s, u32, s32, -2147483649.0, 2147483648.0, 0x80000000u, 0x7fffffffu)
TRUNCATION(trunc32, sat32, u32, u32, -1.0, 4294967296.0, 0u, 0xffffffffu)
/* The number below -2^63 is -2^63 - 2048. */
TRUNCATION(trunc64s, sat64s, u64, s64, -9223372036854777856.0, 9223372036854775808.0, 0x8000000000000000ull, 0x7fffffffffffffffull)
TRUNCATION(trunc64, sat64, u64, u64, -1.0, 18446744073709551616.0, 0ull, 0xffffffffffffffffull)

#endif
