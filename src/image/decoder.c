#include "image/decoder.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "image/decoder_protocol.h"

// ---- The server ----------------------------------------------------------------------------------------------------

#define PROGRAM_NAME "viewworth-decode"
enum { HELLO_TIME_OUT_MS = 120000, END_TIME_OUT_MS = 5000, ADDRESS_SPACE_MIB = 1536 };

struct server {
    pid_t process;
    int socket;
};

// Folders of the decoder, relative to the folder of this code: in a build the same; when installed one beside
// libviewworth.so, and a longer path from the program viewworth. Neither PATH nor another variable decides.
static const char *const program_folders[] = {".", "viewworth", VW_DECODER_FOLDER_FROM_PROGRAM};

// Finds the folder of the library that contains this code, or of the program when it is linked into that; owned by the
// caller.
static char *find_own_folder(void) {
    Dl_info info;
    struct link_map *map = NULL;
    if (dladdr1(program_folders, &info, (void **)&map, RTLD_DL_LINKMAP) && map && map->l_name[0])
        return vw_path_folder(map->l_name);
    char program[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length < 0) return NULL;
    program[length] = 0;
    return vw_path_folder(program);
}

// Finds the first program that exists, owned by the caller; NULL if none does.
static char *find_program(void) {
    char *own_folder = find_own_folder(), *found = NULL;
    for (size_t i = 0; own_folder && i < VW_ARRAY_COUNT(program_folders) && !found; i++) {
        char *folder = vw_path_join(own_folder, program_folders[i]);
        char *path = folder ? vw_path_join(folder, PROGRAM_NAME) : NULL;
        free(folder);
        if (path && vw_file_exists(path)) found = path;
        else free(path);
    }
    free(own_folder);
    return found;
}

// ---- Start ----

// Passes on those of the user's variables that say where libraries are, and those of sanitizers: none that OpenImageIO
// and its libraries read.
static void choose_environment(char *chosen[8]) {
    static const char *const names[] = {"LD_LIBRARY_PATH=", "ASAN_OPTIONS=", "LSAN_OPTIONS=", "UBSAN_OPTIONS="};
    size_t count = 0;
    for (char **variable = environ; variable && *variable; variable++)
        for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++)
            if (count < VW_ARRAY_COUNT(names) && !strncmp(*variable, names[i], strlen(names[i])))
                chosen[count++] = *variable;
    chosen[count] = NULL;
}

// Starts the server with no descriptor of ours but the socket, and no signal: it ends when the socket is closed.
static int spawn(const char *path, int socket, pid_t *process) {
    char *const arguments[] = {PROGRAM_NAME, NULL};
    char *environment[8];
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t all;
    sigfillset(&all);
    choose_environment(environment);
    int error = posix_spawn_file_actions_init(&files);
    if (error) return error;
    error = posix_spawnattr_init(&attributes);
    if (!error) {
        error = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
        if (!error) error = posix_spawnattr_setsigmask(&attributes, &all);
        if (!error) error = posix_spawn_file_actions_adddup2(&files, socket, VW_DECODER_SOCKET);
        for (int i = 0; i < VW_DECODER_SOCKET && !error; i++)
            error = posix_spawn_file_actions_addopen(&files, i, "/dev/null", O_RDWR, 0);
        if (!error) error = posix_spawn_file_actions_addclosefrom_np(&files, VW_DECODER_SOCKET + 1);
        if (!error) error = posix_spawn(process, path, &files, &attributes, arguments, environment);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&files);
    return error;
}

// Stops the server, which ends its workers first. A program that waits for any child may have reaped it already.
static void stop_server(struct server *server) {
    close(server->socket);
    for (int waited_ms = 0; waited_ms < END_TIME_OUT_MS; waited_ms++) {
        pid_t ended = waitpid(server->process, NULL, WNOHANG);
        if (ended == server->process || (ended < 0 && errno != EINTR)) return;
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
    kill(server->process, SIGKILL);
    while (waitpid(server->process, NULL, 0) < 0 && errno == EINTR) {
    }
}

static bool says_hello(int socket) {
    char text[sizeof VW_DECODER_HELLO + 1];
    struct pollfd polled = {socket, POLLIN, 0};
    int ready;
    do ready = poll(&polled, 1, HELLO_TIME_OUT_MS);
    while (ready < 0 && errno == EINTR);
    return ready > 0 && recv(socket, text, sizeof text, MSG_DONTWAIT) == (ssize_t)sizeof VW_DECODER_HELLO &&
           !memcmp(text, VW_DECODER_HELLO, sizeof VW_DECODER_HELLO);
}

static enum vw_status fail_start(const char *why) {
    return vw_fail(VW_ERROR_IO,
                   "cannot start " PROGRAM_NAME ", which reads and writes photos: %s; install viewworth again", why);
}

// Starts the program at `path` (NULL: beside this code, or where it is installed) and waits until it has loaded its
// libraries. VW_ERROR_IO if it is missing or of another version.
static enum vw_status start_server(const char *given_path, struct server *server) {
    struct server started = {0};
    int sockets[2];
    if (vw_check_address_space(ADDRESS_SPACE_MIB, "the libraries that read photos")) return VW_ERROR_MEMORY;
    char *path = given_path ? vw_copy_text(given_path) : find_program();
    if (!path) return fail_start("it is neither beside the program nor in " VW_DECODER_FOLDER_FROM_PROGRAM);
    int error = socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets) ? errno : 0;
    if (error) {
        free(path);
        return fail_start(strerror(error));
    }
    error = spawn(path, sockets[1], &started.process);
    close(sockets[1]);
    free(path);
    if (error) {
        close(sockets[0]);
        return fail_start(strerror(error));
    }
    started.socket = sockets[0];
    if (!says_hello(started.socket)) {
        stop_server(&started);
        return fail_start("a library is missing, or it belongs to another version");
    }
    *server = started;
    return VW_OK;
}

// ---- The library's side --------------------------------------------------------------------------------------------

enum { PARALLEL_MOST = 8, SHORTEST_TIME_OUT_S = 60, LONGEST_TIME_OUT_S = 1800 };
// The number of tasks of its kind after which a worker is replaced. Each photo has its own worker: a file that takes
// over its worker must not reach the pixels of another photo, which may be another provider's. Headers are compared
// with the photo later; pixels to write are ours.
static const uint32_t tasks_of_worker[] = {
    [VW_DECODER_READ_HEADER] = 1024, [VW_DECODER_READ_PHOTO] = 1, [VW_DECODER_WRITE_PHOTO] = 16};
static const uint64_t SMALLEST_MEMORY_BYTES = UINT64_C(512) << 20;

struct worker {
    int socket;
    uint64_t memory_bytes; // a power of two, or what the machine has
    enum vw_decoder_task task;
    uint32_t tasks_left;
    struct worker *next;
};

struct vw_decoder_job {
    struct worker *worker;
    uint64_t payload_left;    // left of the answer, once it has begun
    double time_out_s, end_s; // how long, and until when it is waited for
    bool answered;
};

static struct {
    pthread_mutex_t lock;
    uint32_t users; // who use the program, and jobs
    bool running;
    struct server server;
    struct worker *idle;
    struct vw_decoder_params params;
} decoder = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void lock(void) { (void)pthread_mutex_lock(&decoder.lock); }
static void unlock(void) { (void)pthread_mutex_unlock(&decoder.lock); }

// ---- Processes, under the lock ----

static void close_worker(struct worker *worker) {
    close(worker->socket); // the server kills it
    free(worker);
}

static void stop(void) {
    while (decoder.idle) {
        struct worker *worker = decoder.idle;
        decoder.idle = worker->next;
        close_worker(worker);
    }
    if (decoder.running) stop_server(&decoder.server);
    decoder.running = false;
}

static bool send_with_descriptor(int socket, const void *data, size_t size_bytes, int descriptor) {
    union {
        char bytes[CMSG_SPACE(sizeof(int))];
        struct cmsghdr aligned;
    } control = {0};
    struct iovec part = {(void *)data, size_bytes};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};
    if (descriptor >= 0) {
        message.msg_control = &control;
        message.msg_controllen = sizeof control;
        struct cmsghdr *header = CMSG_FIRSTHDR(&message);
        *header = (struct cmsghdr){
            .cmsg_level = SOL_SOCKET, .cmsg_type = SCM_RIGHTS, .cmsg_len = CMSG_LEN(sizeof descriptor)};
        memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
    }
    ssize_t sent;
    do sent = sendmsg(socket, &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    return sent == (ssize_t)size_bytes;
}

// Seconds that all tasks of a worker may compute, and that one may be waited for: a slow decoder on a slow machine does
// some megabytes a second.
static uint64_t seconds_for(uint64_t memory_bytes) {
    uint64_t seconds = SHORTEST_TIME_OUT_S + (memory_bytes >> 22);
    return seconds < LONGEST_TIME_OUT_S ? seconds : LONGEST_TIME_OUT_S;
}

static uint64_t machine_bytes(void) { return (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE); }

static enum vw_status start_worker(enum vw_decoder_task task, uint64_t memory_bytes, struct worker **worker) {
    const struct vw_decoder_order order = {.memory_bytes = memory_bytes, .cpu_s = seconds_for(memory_bytes)};
    int sockets[2];
    struct worker *started = vw_allocate(1, sizeof *started);
    if (!started) return VW_ERROR_MEMORY;
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets)) {
        free(started);
        return vw_fail(VW_ERROR_IO, "cannot make a socket: %s", strerror(errno));
    }
    enum vw_status status = VW_OK;
    bool ordered = false;
    for (int attempt = 0; attempt < 2 && !ordered && !status; attempt++) { // somebody may have killed the server
        if (attempt) stop();
        if (!decoder.running) status = start_server(decoder.params.program, &decoder.server);
        decoder.running = !status;
        ordered = !status && send_with_descriptor(decoder.server.socket, &order, sizeof order, sockets[1]);
    }
    close(sockets[1]);
    if (!status && ordered) {
        *started = (struct worker){
            .socket = sockets[0], .memory_bytes = memory_bytes, .task = task, .tasks_left = tasks_of_worker[task]};
        *worker = started;
        return VW_OK;
    }
    close(sockets[0]);
    free(started);
    return status ? status : vw_fail(VW_ERROR_IO, "viewworth-decode does not answer; run the command again");
}

// Returns whether an idle worker neither ended nor sent anything unasked.
static bool is_quiet(const struct worker *worker) {
    struct pollfd polled = {worker->socket, POLLIN, 0};
    return !poll(&polled, 1, 0);
}

// Takes an idle worker or starts one. Bounds are powers of two, so that an idle worker of that kind of task mostly has
// the bound that is needed.
static enum vw_status take_worker(enum vw_decoder_task task, uint64_t memory_bytes, struct worker **worker) {
    uint64_t bound = SMALLEST_MEMORY_BYTES;
    while (bound < memory_bytes) bound *= 2;
    if (bound > machine_bytes()) bound = machine_bytes(); // no honest file takes more
    for (struct worker **at = &decoder.idle; *at;) {
        struct worker *found = *at;
        if (found->memory_bytes != bound || found->task != task) {
            at = &found->next;
            continue;
        }
        *at = found->next;
        if (is_quiet(found)) {
            *worker = found;
            return VW_OK;
        }
        close_worker(found);
    }
    return start_worker(task, bound, worker);
}

static void give_back(struct worker *worker) {
    worker->next = decoder.idle;
    decoder.idle = worker;
    uint32_t count = 0;
    for (struct worker **at = &decoder.idle; *at; at = &(*at)->next) {
        if (++count <= PARALLEL_MOST) continue;
        close_worker(*at); // the one that has waited longest
        *at = NULL;
        return;
    }
}

// ---- Holding ----

void vw_decoder_configure(const struct vw_decoder_params *params) {
    lock();
    decoder.params = *params;
    unlock();
}

void vw_decoder_hold(void) {
    lock();
    decoder.users++;
    unlock();
}

void vw_decoder_release(void) {
    lock();
    if (decoder.users && !--decoder.users) stop();
    unlock();
}

uint32_t vw_decoder_parallel_count(void) {
    cpu_set_t set;
    int count = sched_getaffinity(0, sizeof set, &set) ? 1 : CPU_COUNT(&set);
    return count < 1 ? 1 : count < PARALLEL_MOST ? (uint32_t)count : PARALLEL_MOST;
}

// ---- Tasks ----

static enum vw_status fail_worker(void) {
    return vw_fail(VW_ERROR_IO, "the decoder crashed on it, or needed too much memory or time");
}

// Waits until bytes can be received or sent.
static bool await(const struct vw_decoder_job *job, short event) {
    for (;;) {
        struct pollfd polled = {job->worker->socket, event, 0};
        double left_s = job->end_s - vw_now_s();
        int ready = left_s > 0 ? poll(&polled, 1, (int)(left_s * 1000) + 1) : 0;
        if (ready > 0) return true;
        if (!ready || errno != EINTR) return false;
    }
}

static enum vw_status receive(struct vw_decoder_job *job, void *data, size_t size_bytes) {
    for (size_t used = 0; used < size_bytes;) {
        if (!await(job, POLLIN)) return fail_worker();
        ssize_t got = recv(job->worker->socket, (char *)data + used, size_bytes - used, MSG_DONTWAIT);
        if (!got || (got < 0 && errno != EAGAIN && errno != EINTR)) return fail_worker();
        if (got > 0) used += (size_t)got;
    }
    return VW_OK;
}

static enum vw_status send_payload(struct vw_decoder_job *job, const void *data, size_t size_bytes) {
    for (size_t used = 0; used < size_bytes;) {
        if (!await(job, POLLOUT)) return fail_worker();
        ssize_t sent =
            send(job->worker->socket, (const char *)data + used, size_bytes - used, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent < 0 && errno != EAGAIN && errno != EINTR) return fail_worker();
        if (sent > 0) used += (size_t)sent;
    }
    return VW_OK;
}

enum vw_status vw_decoder_begin(const struct vw_decoder_request *request, int descriptor, const void *payload,
                                size_t payload_bytes, uint64_t memory_bytes, struct vw_decoder_job **job) {
    struct vw_decoder_job *begun = vw_allocate(1, sizeof *begun);
    if (!begun) return VW_ERROR_MEMORY;
    lock();
    decoder.users++;
    begun->time_out_s = decoder.params.time_out_s;
    enum vw_status status = take_worker(request->task, memory_bytes, &begun->worker);
    unlock();
    if (!status) {
        begun->worker->tasks_left--;
        if (!begun->time_out_s) begun->time_out_s = (double)seconds_for(begun->worker->memory_bytes);
        begun->end_s = vw_now_s() + begun->time_out_s;
        if (!send_with_descriptor(begun->worker->socket, request, sizeof *request, descriptor)) status = fail_worker();
    }
    if (!status) status = send_payload(begun, payload, payload_bytes);
    if (status) vw_decoder_end(&begun);
    else *job = begun;
    return status;
}

static bool is_known(uint32_t status) {
    return !status || status == VW_ERROR_INPUT || status == VW_ERROR_IO || status == VW_ERROR_MEMORY ||
           status == VW_ERROR_USAGE;
}

enum vw_status vw_decoder_finish(struct vw_decoder_job *job, struct vw_decoder_answer *answer) {
    job->end_s = vw_now_s() + job->time_out_s; // meanwhile the caller may have been busy
    enum vw_status status = receive(job, answer, sizeof *answer);
    if (status) return status;
    if (!is_known(answer->status)) return fail_worker();
    job->answered = true;
    job->payload_left = answer->status ? 0 : answer->payload_bytes;
    answer->message[sizeof answer->message - 1] = 0;
    return answer->status ? vw_fail((enum vw_status)answer->status, "%s", answer->message) : VW_OK;
}

enum vw_status vw_decoder_receive(struct vw_decoder_job *job, void *data, size_t size_bytes) {
    if (size_bytes > job->payload_left) return fail_worker();
    enum vw_status status = receive(job, data, size_bytes);
    if (!status) job->payload_left -= size_bytes;
    return status;
}

void vw_decoder_end(struct vw_decoder_job **job) {
    struct vw_decoder_job *ending = job ? *job : NULL;
    if (!ending) return;
    struct vw_saved_error kept = vw_error_save();
    struct worker *worker = ending->worker;
    bool reusable = worker && ending->answered && !ending->payload_left && worker->tasks_left > 0;
    lock();
    if (reusable) give_back(worker);
    else if (worker) close_worker(worker);
    unlock();
    vw_decoder_release();
    free(ending);
    *job = NULL;
    vw_error_restore(&kept);
}
