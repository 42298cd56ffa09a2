/* The two roofs of a machine: multiply-adds that do not wait for each other, and the stream triad. One core each. */
#include <stddef.h>

#ifdef __AVX512F__
#define WIDTH 8
#else
#define WIDTH 4
#endif
#define CHAINS 12 /* more than latency times throughput of any multiply-add, and few enough for sixteen registers */
typedef double Pack __attribute__((vector_size(8 * WIDTH)));

/* Flies n rounds and returns the number of floating-point operations; the sum keeps them from being optimised away. */
double multiply_adds(long n, double factor, double *sum) {
    Pack a[CHAINS], f;
    for (int j = 0; j < WIDTH; j++) f[j] = factor;
    for (int i = 0; i < CHAINS; i++)
        for (int j = 0; j < WIDTH; j++) a[i][j] = i + j;
    for (long k = 0; k < n; k++) {
#pragma GCC unroll 12
        for (int i = 0; i < CHAINS; i++) a[i] = a[i] * f + f;
    }
    *sum = 0.0;
    for (int i = 0; i < CHAINS; i++)
        for (int j = 0; j < WIDTH; j++) *sum += a[i][j];
    return 2.0 * CHAINS * WIDTH * (double)n;
}

/* a = b + s c; moves three doubles an element, as the benchmark counts them. */
void triad(double *restrict a, const double *restrict b, const double *restrict c, double s, size_t n) {
    for (size_t i = 0; i < n; i++) a[i] = b[i] + s * c[i];
}
