#include "image/decoder_server.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "image/decoder_protocol.h"

#define PROGRAM_NAME "viewworth-decode"
enum { HELLO_TIME_OUT_MS = 120000, END_TIME_OUT_MS = 5000, ADDRESS_SPACE_MIB = 1536 };

// ---- Where the program is ----

// Seen from the folder of this code: in a build beside it; installed in a folder beside libviewworth.so, to which the
// program viewworth has a longer way. Neither PATH nor another variable has a say.
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
static int spawn(const char *path, int socket, bool without_seccomp, pid_t *process) {
    char *const arguments[] = {PROGRAM_NAME, without_seccomp ? "--without-seccomp" : NULL, NULL};
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

enum vw_status vw_decoder_server_start(const char *given_path, bool without_seccomp, struct vw_decoder_server *server) {
    struct vw_decoder_server started = {0};
    int sockets[2];
    if (vw_check_address_space(ADDRESS_SPACE_MIB, "the libraries that read photos")) return VW_ERROR_MEMORY;
    char *path = given_path ? vw_copy_text(given_path) : find_program();
    if (!path) return fail_start("it is neither beside the program nor in " VW_DECODER_FOLDER_FROM_PROGRAM);
    int error = socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets) ? errno : 0;
    if (error) {
        free(path);
        return fail_start(strerror(error));
    }
    error = spawn(path, sockets[1], without_seccomp, &started.process);
    close(sockets[1]);
    free(path);
    if (error) {
        close(sockets[0]);
        return fail_start(strerror(error));
    }
    started.socket = sockets[0];
    if (!says_hello(started.socket)) {
        vw_decoder_server_stop(&started);
        return fail_start("a library is missing, or it belongs to another version");
    }
    *server = started;
    return VW_OK;
}

// ---- End ----

// Stops the server, which ends its workers first. A program that waits for any child may have reaped it already.
void vw_decoder_server_stop(struct vw_decoder_server *server) {
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
