/* A program with the sockets and threads of Betaflight's simulator whose motors are its throttle stick, on a machine that is busy:
   its thread of the sticks is late to take a packet and late to be done with it, and every ioctl takes its time. */
#include <arpa/inet.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

enum { STATE = 9003, STICKS = 9004, MOTORS = 9002, THROTTLE = 2 };
static struct { double time; uint16_t channels[16]; } packet;
static volatile uint16_t taken = 1000;

static void wait_ms(long duration)
{
    const struct timespec length = {.tv_nsec = duration * 1000000};
    nanosleep(&length, NULL);
}

int ioctl(int file, unsigned long request, ...)
{
    va_list more;
    va_start(more, request);
    void *given = va_arg(more, void *);
    va_end(more);
    wait_ms(6);
    return (int)syscall(SYS_ioctl, file, request, given);
}

static struct sockaddr_in at(int port)
{
    return (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons(port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
}

static int opened(int port)
{
    const struct sockaddr_in place = at(port);
    const int made = socket(AF_INET, SOCK_DGRAM, 0);
    bind(made, (const struct sockaddr *)&place, sizeof place);
    return made;
}

static int comes(int from)
{
    fd_set waiting;
    FD_ZERO(&waiting);
    FD_SET(from, &waiting);
    return select(from + 1, &waiting, NULL, NULL, NULL) == 1;
}

static void *take_sticks(void *given)
{
    for (const int from = *(int *)given;;)
        if (comes(from)) {
            wait_ms(2);
            recvfrom(from, &packet, sizeof packet, 0, NULL, NULL);
            wait_ms(12);
            taken = packet.channels[THROTTLE];
        }
    return NULL;
}

static void *take_state(void *given)
{
    char state[512];
    for (const int from = *(int *)given;;)
        if (comes(from))
            recvfrom(from, state, sizeof state, 0, NULL, NULL);
    return NULL;
}

int main(void)
{
    const struct sockaddr_in out = at(MOTORS);
    struct timespec now;
    pthread_t thread;
    int state = opened(STATE), sticks = opened(STICKS), motors = socket(AF_INET, SOCK_DGRAM, 0);
    pthread_create(&thread, NULL, take_sticks, &sticks);
    pthread_create(&thread, NULL, take_state, &state);
    for (;;) {
        const float share = (float)(taken - 1000) / 1000.0f, shares[4] = {share, share, share, share};
        sendto(motors, shares, sizeof shares, 0, (const struct sockaddr *)&out, sizeof out);
        clock_gettime(CLOCK_MONOTONIC, &now);
    }
}
