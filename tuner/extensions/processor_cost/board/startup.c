/* Start of a Cortex-M4F program under QEMU: vectors, floating-point unit, semihosting, main. */

#include <stdlib.h>

extern unsigned bss_start[], bss_end[], stack_top[];
void initialise_monitor_handles(void);
int main(void);
void reset(void);

static void fault(void)
{
    _Exit(EXIT_FAILURE);
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_top, (const void *)reset, (const void *)fault, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault,
};

/* newlib's start files are left out; its exit asks for these two. */
void _init(void) {}
void _fini(void) {}

void reset(void)
{
    volatile unsigned *const cpacr = (volatile unsigned *)0xE000ED88u;
    *cpacr |= 0xFu << 20; /* full access to coprocessors 10 and 11, the floating-point unit */
    __asm volatile("dsb\n\tisb" ::: "memory");
    for (unsigned *word = bss_start; word < bss_end; ++word)
        *word = 0u;
    initialise_monitor_handles();
    exit(main());
}
