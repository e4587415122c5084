// viewworth-decode: the server that the library starts to read and write photos. See image/decoder_protocol.h.
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "image/decode/oiio_shim.h"
#include "image/decode/tasks.h"
#include "image/decoder_protocol.h"

struct worker {
    pid_t process;
    int socket; // the library's end hangs up when it gives the worker up
};

static struct {
    struct worker workers[VW_DECODER_WORKERS_MAX];
    uint32_t count;
    int ended; // signalfd: a worker has ended
} server;

static void start(const struct vw_decoder_order *order, int socket) {
    pid_t server_process = getpid();
    pid_t process = server.count < VW_DECODER_WORKERS_MAX ? fork() : -1;
    if (process > 0) server.workers[server.count++] = (struct worker){process, socket};
    if (process < 0) close(socket);
    if (process) return;
    // The worker: it ends with the server, and has no descriptor but its socket.
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) || getppid() != server_process) _exit(1);
    if (dup2(socket, VW_DECODER_SOCKET) != VW_DECODER_SOCKET) _exit(1);
    closefrom(VW_DECODER_SOCKET + 1);
    _exit(vw_worker_run(order) ? 0 : 1);
}

static bool take_order(void) {
    struct vw_decoder_order order;
    int socket = -1;
    ssize_t got = vw_worker_receive(VW_DECODER_SOCKET, &order, sizeof order, &socket);
    if (got == (ssize_t)sizeof order && socket >= 0) start(&order, socket);
    else if (socket >= 0) close(socket);
    return got > 0; // 0: the library has closed its end, or ended
}

// Reaps dead workers. The library sees the end of a worker by the end of its socket.
static void bury(void) {
    struct signalfd_siginfo info;
    ssize_t ignored = read(server.ended, &info, sizeof info);
    (void)ignored; // several ends may have made one signal
    for (pid_t process; (process = waitpid(-1, NULL, WNOHANG)) > 0;) {
        for (uint32_t i = 0; i < server.count; i++) {
            if (server.workers[i].process != process) continue;
            close(server.workers[i].socket);
            server.workers[i] = server.workers[--server.count];
            break;
        }
    }
}

static bool serve(void) {
    struct pollfd polled[2 + VW_DECODER_WORKERS_MAX] = {{VW_DECODER_SOCKET, POLLIN, 0}, {server.ended, POLLIN, 0}};
    uint32_t count = server.count;
    for (uint32_t i = 0; i < count; i++) polled[2 + i] = (struct pollfd){server.workers[i].socket, 0, 0};
    if (poll(polled, 2 + count, -1) < 0) return true;
    for (uint32_t i = 0; i < count; i++)
        if (polled[2 + i].revents) kill(server.workers[i].process, SIGKILL);
    if (polled[1].revents) bury();
    return !polled[0].revents || take_order();
}

static void stop(void) {
    for (uint32_t i = 0; i < server.count; i++) kill(server.workers[i].process, SIGKILL);
    while (waitpid(-1, NULL, 0) > 0) {
    }
}

// Unblocks the signals that the library has blocked: the process acts on those of the terminal itself.
int main(void) {
    sigset_t child;
    if (!vw_streams_prepare()) return 1;
    sigemptyset(&child);
    sigaddset(&child, SIGCHLD);
    server.ended = signalfd(-1, &child, SFD_CLOEXEC | SFD_NONBLOCK);
    if (server.ended < 0 || sigprocmask(SIG_BLOCK, &child, NULL)) return 1;
    vw_oiio_prepare_server();
    if (send(VW_DECODER_SOCKET, VW_DECODER_HELLO, sizeof VW_DECODER_HELLO, MSG_NOSIGNAL) < 0) return 2;
    while (serve()) {
    }
    stop();
    return 0;
}
