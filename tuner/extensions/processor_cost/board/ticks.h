/* Instructions counted by SysTick under `qemu-system-arm -icount shift=10`: an instruction takes 1024 ns of virtual time and
   SysTick counts down at 25 MHz, so an instruction is 25.6 ticks. A section must stay below 655 000 instructions (24 bits). */

#ifndef TICKS_H
#define TICKS_H

#define SYST_CSR (*(volatile unsigned *)0xE000E010u)
#define SYST_RVR (*(volatile unsigned *)0xE000E014u)
#define SYST_CVR (*(volatile unsigned *)0xE000E018u)

static inline void ticks_start(void)
{
    SYST_RVR = 0xFFFFFFu;
    SYST_CVR = 0u;
    SYST_CSR = 5u; /* processor clock, no interrupt */
    while (SYST_CVR == 0u) /* it stands at 0 until it is reloaded */
        ;
}

static inline unsigned ticks_now(void)
{
    unsigned now;
    __asm volatile("" ::: "memory");
    now = SYST_CVR;
    __asm volatile("" ::: "memory");
    return now;
}

static inline unsigned ticks_between(unsigned before, unsigned after)
{
    return (before - after) & 0xFFFFFFu;
}

/* Instructions in `ticks`; `empty`: ticks between two readings with nothing in between. */
static inline unsigned instructions(unsigned ticks, unsigned empty)
{
    return ((ticks - empty) * 10u + 128u) / 256u;
}

#endif
