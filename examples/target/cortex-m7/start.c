/* Where a Cortex-M7 begins: its vectors, and the floating-point unit switched on. The rest is newlib's. */
#include <stdint.h>

extern uint32_t stack_top;
void _start(void);

static void reset(void) {
    /* Full access to coprocessors 10 and 11, which are the floating-point unit. */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm__ volatile("dsb\n\tisb");
    _start();
}

static void fault(void) {
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))&stack_top, reset, fault, fault, fault, fault, fault,
};
