#include "batch/child.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/memory.h"

enum { INPUT, OUTPUT, ERRORS }; // the descriptors that a process begins with

// The environment with the variable of this process: an owned array whose first text is owned.
static char **make_environment(void) {
    static const char name[] = VW_CHILD_PARENT_VARIABLE "=";
    size_t count = 0, used = 0;
    while (environ && environ[count]) count++;
    char **made = vw_allocate(count + 2, sizeof *made);
    char *own = made ? vw_format_text("%s%ld", name, (long)getpid()) : NULL;
    if (!own) {
        free(made);
        return NULL;
    }
    made[used++] = own;
    for (size_t i = 0; i < count; i++)
        if (strncmp(environ[i], name, strlen(name)) != 0) made[used++] = environ[i];
    return made;
}

static int spawn(const char *program, char *const *words, char *const *environment, const char *log_path,
                 pid_t *process) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    int error = posix_spawn_file_actions_init(&files);
    if (error) return error;
    error = posix_spawnattr_init(&attributes);
    if (!error) {
        const int to_log = O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY;
        error = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
        if (!error) error = posix_spawn_file_actions_addopen(&files, INPUT, "/dev/null", O_RDONLY, 0);
        if (!error) error = posix_spawn_file_actions_addopen(&files, OUTPUT, log_path, to_log, 0666);
        if (!error) error = posix_spawn_file_actions_adddup2(&files, OUTPUT, ERRORS);
        if (!error) error = posix_spawn_file_actions_addclosefrom_np(&files, ERRORS + 1);
        if (!error) error = posix_spawn(process, program, &files, &attributes, words, environment);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&files);
    return error;
}

enum vw_status vw_child_start(const char *program, char *const *words, const char *log_path, pid_t *process) {
    char **environment = make_environment();
    if (!environment) return VW_ERROR_MEMORY;
    int error = spawn(program, words, environment, log_path, process);
    free(environment[0]);
    free(environment);
    if (!error) return VW_OK;
    return vw_fail(VW_ERROR_IO, "%s: cannot start a process that writes there: %s; check the folder", log_path,
                   strerror(error));
}

static int spawn_into_pipe(char *const *words, int end, pid_t *process) {
    posix_spawn_file_actions_t files;
    int error = posix_spawn_file_actions_init(&files);
    if (error) return error;
    error = posix_spawn_file_actions_addopen(&files, INPUT, "/dev/null", O_RDONLY, 0);
    if (!error) error = posix_spawn_file_actions_adddup2(&files, end, OUTPUT);
    if (!error) error = posix_spawn_file_actions_adddup2(&files, OUTPUT, ERRORS);
    if (!error) error = posix_spawn_file_actions_addclosefrom_np(&files, ERRORS + 1);
    if (!error) error = posix_spawnp(process, words[0], &files, NULL, words, environ);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

// To its end, so that nobody who writes is stopped by a full pipe.
static void read_all(int end, char *text, size_t size) {
    char dropped[256];
    size_t used = 0;
    for (;;) {
        bool full = used + 1 >= size;
        ssize_t got = read(end, full ? dropped : text + used, full ? sizeof dropped : size - 1 - used);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        if (!full) used += (size_t)got;
    }
    text[used] = 0;
}

enum vw_status vw_child_read(char *const *words, char *text, size_t size, int *exit_code) {
    int ends[2], wait_status = 0;
    pid_t process = 0;
    if (pipe2(ends, O_CLOEXEC)) return vw_fail(VW_ERROR_IO, "%s: cannot make a pipe: %s", words[0], strerror(errno));
    int error = spawn_into_pipe(words, ends[1], &process);
    close(ends[1]);
    if (!error) read_all(ends[0], text, size);
    close(ends[0]);
    if (error) return vw_fail(VW_ERROR_IO, "%s: cannot be started: %s; is it installed?", words[0], strerror(error));
    while (waitpid(process, &wait_status, 0) < 0 && errno == EINTR) continue;
    *exit_code = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : -1;
    return VW_OK;
}
