/* Preloaded into a firmware that listens on every interface at ports of its own: each of its sockets gets the loopback and a free port
   instead. "ASKED GIVEN" of each goes into the file that LOOPBACK_PORTS names. The process dies with the one that started it. */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <dlfcn.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>

__attribute__((constructor)) static void end_with_the_parent(void)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
}

int socket(int domain, int type, int protocol)
{
    int (*make)(int, int, int), (*place)(int, const struct sockaddr *, socklen_t);
    const struct sockaddr_in free_port = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    *(void **)&make = dlsym(RTLD_NEXT, "socket");
    *(void **)&place = dlsym(RTLD_NEXT, "bind");
    const int made = make(AF_INET, type, protocol);
    if (domain != AF_INET || place(made, (const struct sockaddr *)&free_port, sizeof free_port) != 0)
        abort();
    return made;
}

int bind(int made, const struct sockaddr *asked, socklen_t size)
{
    struct sockaddr_in wanted, given;
    socklen_t length = sizeof given;
    FILE *ports = fopen(getenv("LOOPBACK_PORTS"), "a");
    if (!ports || size < sizeof wanted || getsockname(made, (struct sockaddr *)&given, &length) != 0)
        abort();
    memcpy(&wanted, asked, sizeof wanted);
    fprintf(ports, "%d %d\n", ntohs(wanted.sin_port), ntohs(given.sin_port));
    return fclose(ports);
}
