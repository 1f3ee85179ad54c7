/* Sums in double precision by integers, for processors that compute them by calls of a library that rounds some wrongly. */
#include "code.h"

#ifdef SUMS_BY_INTEGERS

/* Bits of a number below its exponent, with three more for what is rounded: half, quarter, and whether anything is below. */
#define LEADING ((u64)1 << 55)
#define NOT_FINITE 2047u

/* The sum, rounded to the nearest number, and to the even one in the middle of two. */
f64 module_sum64(f64 x, f64 y) {
    u64 large = bits64(x), small = bits64(y), sign, rest;
    u32 exponent, distance;
    int is_difference;
    if (large << 1 < small << 1) {
        rest = large;
        large = small;
        small = rest;
    }
    exponent = (u32)(large >> 52) & 2047u;
    distance = (u32)(small >> 52) & 2047u;
    if (exponent == NOT_FINITE) return x + y;
    sign = large >> 63 << 63;
    is_difference = (large ^ small) >> 63 != 0;
    large = large << 12 >> 9;
    small = small << 12 >> 9;
    /* The least numbers have no leading bit, and the exponent of the next. */
    if (exponent) large |= LEADING;
    else exponent = 1;
    if (distance) small |= LEADING;
    else distance = 1;
    distance = exponent - distance;
    if (distance > 55) {
        small = small != 0;
    } else {
        rest = small;
        small >>= distance;
        small |= small << distance != rest;
    }
    if (is_difference) {
        large -= small;
        if (large == 0) return 0.0;
        if (large < LEADING) {
            u32 shift = (u32)clz64(large) - 8u;
            if (shift >= exponent) shift = exponent - 1;
            large <<= shift;
            exponent -= shift;
        }
    } else {
        large += small;
        if (large >= LEADING << 1) {
            large = large >> 1 | (large & 1);
            exponent++;
        }
    }
    rest = large & 7;
    /* The leading bit adds one to the exponent, and so does a number that is rounded up to the next. */
    large = (large >> 3) + ((u64)(exponent - 1) << 52);
    large += rest > 4 || (rest == 4 && (large & 1));
    if (large >> 52 >= NOT_FINITE) large = (u64)NOT_FINITE << 52;
    return of_bits64(large | sign);
}

#endif
