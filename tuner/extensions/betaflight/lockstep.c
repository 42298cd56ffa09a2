/* Loaded before Betaflight's simulator program: its sockets lead to whoever started it, and its clock is theirs.

   LOCKSTEP_LINE: a listening socket, in place of the port of the command line. LOCKSTEP_STATE, LOCKSTEP_STICKS, LOCKSTEP_MOTORS:
   sockets in place of the ports for the state of the plant, for the sticks and for the motors; with them the program runs in
   lockstep. Simulated time passes as the main thread looks at the clock or sleeps. Where it has used up LOCKSTEP_PERIOD [ns], the
   last motor commands are sent and the thread waits until a further state has been taken in. No other socket leaves the loopback,
   and the program ends with whoever started it. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <netinet/in.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define REAL(result, name, ...) \
    static result (*real)(__VA_ARGS__); \
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, #name)

enum { MOTORS = 9002, STATE = 9003, STICKS = 9004, LINE = 5761, PACKET = 64, MOTORS_SIZE = 16 };
static const int64_t SECOND = 1000000000, BOOT = 1000000000, LOOK = 1000, LONGEST_SLEEP = 10000;

static int line = -1, state = -1, sticks = -1, motors = -1, lockstep;
static int64_t period, now, granted = BOOT;
static char last[PACKET];
static size_t last_size = MOTORS_SIZE;
static int sticks_in_hand;
static __thread int state_in_hand;
static pthread_t main_thread;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t more = PTHREAD_COND_INITIALIZER;

static int64_t number(const char *name)
{
    const char *text = getenv(name);
    return text ? atoll(text) : -1;
}

__attribute__((constructor)) static void begin(void)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    main_thread = pthread_self();
    line = (int)number("LOCKSTEP_LINE");
    state = (int)number("LOCKSTEP_STATE");
    sticks = (int)number("LOCKSTEP_STICKS");
    motors = (int)number("LOCKSTEP_MOTORS");
    period = number("LOCKSTEP_PERIOD");
    lockstep = state >= 0 && sticks >= 0 && motors >= 0 && period > 0;
}

/* Sockets. */

int socket(int domain, int type, int protocol)
{
    REAL(int, socket, int, int, int);
    return real(domain == AF_INET6 ? AF_INET : domain, type, protocol);
}

static int stands_for(int *ours, int made)
{
    const int given = dup2(*ours, made);
    *ours = made;
    return given < 0 ? -1 : 0;
}

int bind(int made, const struct sockaddr *asked, socklen_t size)
{
    REAL(int, bind, int, const struct sockaddr *, socklen_t);
    struct sockaddr_in wanted, inside = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    if (size < sizeof wanted)
        return real(made, asked, size);
    memcpy(&wanted, asked, sizeof wanted);
    const int port = ntohs(wanted.sin_port);
    if (port == STATE && state >= 0)
        return stands_for(&state, made);
    if (port == STICKS && sticks >= 0)
        return stands_for(&sticks, made);
    if (port == LINE && line >= 0)
        return stands_for(&line, made);
    return real(made, (const struct sockaddr *)&inside, sizeof inside);
}

ssize_t sendto(int socket, const void *data, size_t size, int flags, const struct sockaddr *to, socklen_t length)
{
    REAL(ssize_t, sendto, int, const void *, size_t, int, const struct sockaddr *, socklen_t);
    if (!to || to->sa_family != AF_INET)
        return real(socket, data, size, flags, to, length);
    if (ntohs(((const struct sockaddr_in *)to)->sin_port) == MOTORS && size <= sizeof last) {
        memcpy(last, data, size);
        last_size = size;
    }
    return (ssize_t)size;
}

/* Time. */

static void pass(int64_t length)
{
    now += length;
    if (now < granted)
        return;
    now = granted;
    pthread_mutex_lock(&lock);
    if (send(motors, last, last_size, MSG_NOSIGNAL) < 0)
        _exit(1);
    while (granted <= now)
        pthread_cond_wait(&more, &lock);
    pthread_mutex_unlock(&lock);
}

/* Called where the thread of the state comes back for more: what it had is taken in, and so are the sticks that were sent before.
   The queue is asked first: a packet that has left it is in hand already, but one that was not in hand may leave it meanwhile. */
static void grant(void)
{
    int waiting = 0;
    while ((ioctl(sticks, FIONREAD, &waiting) == 0 && waiting > 0) || __atomic_load_n(&sticks_in_hand, __ATOMIC_SEQ_CST))
        sched_yield();
    pthread_mutex_lock(&lock);
    granted = now + period;
    pthread_cond_signal(&more);
    pthread_mutex_unlock(&lock);
}

int clock_gettime(clockid_t which, struct timespec *out)
{
    REAL(int, clock_gettime, clockid_t, struct timespec *);
    if (!lockstep || which != CLOCK_MONOTONIC)
        return real(which, out);
    if (pthread_equal(pthread_self(), main_thread))
        pass(LOOK);
    out->tv_sec = 1 + now / SECOND;
    out->tv_nsec = now % SECOND;
    return 0;
}

int nanosleep(const struct timespec *asked, struct timespec *left)
{
    REAL(int, nanosleep, const struct timespec *, struct timespec *);
    if (!lockstep || !pthread_equal(pthread_self(), main_thread))
        return real(asked, left);
    const int64_t length = asked->tv_sec * SECOND + asked->tv_nsec;
    if (left)
        *left = (struct timespec){0};
    pass(length < LONGEST_SLEEP ? length : LONGEST_SLEEP);
    return 0;
}

/* Packets. */

int select(int count, fd_set *in, fd_set *out, fd_set *bad, struct timeval *longest)
{
    REAL(int, select, int, fd_set *, fd_set *, fd_set *, struct timeval *);
    if (lockstep && state_in_hand) {
        state_in_hand = 0;
        grant();
    }
    if (lockstep && count == sticks + 1)
        __atomic_store_n(&sticks_in_hand, 0, __ATOMIC_SEQ_CST);
    return real(count, in, out, bad, longest);
}

ssize_t recvfrom(int socket, void *data, size_t size, int flags, struct sockaddr *from, socklen_t *length)
{
    REAL(ssize_t, recvfrom, int, void *, size_t, int, struct sockaddr *, socklen_t *);
    if (!lockstep || (socket != state && socket != sticks))
        return real(socket, data, size, flags, from, length);
    if (socket == sticks)
        __atomic_store_n(&sticks_in_hand, 1, __ATOMIC_SEQ_CST);
    const ssize_t got = real(socket, data, size, flags, NULL, NULL);
    if (got == 0)
        _exit(0);
    if (socket == state && got > 0)
        state_in_hand = 1;
    return got;
}
