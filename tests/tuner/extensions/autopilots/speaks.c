/* A program with the sockets and threads of Betaflight's simulator that flies nothing: SIZE bytes of motors, all zero, again and again. */
#include <arpa/inet.h>
#include <pthread.h>
#include <stddef.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <time.h>

static struct sockaddr_in at(int port)
{
    return (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons(port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
}

static void *take(void *given)
{
    const int state = *(int *)given;
    char packet[512];
    for (;;) {
        fd_set waiting;
        FD_ZERO(&waiting);
        FD_SET(state, &waiting);
        if (select(state + 1, &waiting, NULL, NULL, NULL) == 1)
            recvfrom(state, packet, sizeof packet, 0, NULL, NULL);
    }
    return NULL;
}

int main(void)
{
    const char zeros[SIZE] = {0};
    const struct sockaddr_in in = at(9003), sticks = at(9004), out = at(9002);
    struct timespec now;
    pthread_t thread;
    int state = socket(AF_INET, SOCK_DGRAM, 0), other = socket(AF_INET, SOCK_DGRAM, 0), motors = socket(AF_INET, SOCK_DGRAM, 0);
    bind(state, (const struct sockaddr *)&in, sizeof in);
    bind(other, (const struct sockaddr *)&sticks, sizeof sticks);
    pthread_create(&thread, NULL, take, &other);
    pthread_create(&thread, NULL, take, &state);
    for (;;) {
        sendto(motors, zeros, sizeof zeros, 0, (const struct sockaddr *)&out, sizeof out);
        clock_gettime(CLOCK_MONOTONIC, &now);
    }
}
