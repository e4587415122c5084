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

static bool is_own_variable(const char *variable) {
    static const char *const own[] = {VW_CHILD_PARENT_VARIABLE "=", VW_CHILD_SEEDS_VARIABLE "="};
    for (size_t i = 0; i < VW_ARRAY_COUNT(own); i++)
        if (!strncmp(variable, own[i], strlen(own[i]))) return true;
    return false;
}

enum { OWN_VARIABLES = 2 };

static void free_environment(char **environment) {
    for (int i = 0; i < OWN_VARIABLES && environment; i++) free(environment[i]);
    free(environment);
}

// Builds the environment with the variables of a child: an owned array whose first OWN_VARIABLES texts are owned.
static char **make_environment(const char *seeds) {
    size_t count = 0, used = OWN_VARIABLES;
    while (environ && environ[count]) count++;
    char **made = vw_allocate(count + OWN_VARIABLES + 1, sizeof *made);
    if (!made) return NULL;
    made[0] = vw_format_text(VW_CHILD_PARENT_VARIABLE "=%ld", (long)getpid());
    made[1] = vw_format_text(VW_CHILD_SEEDS_VARIABLE "=%s", seeds);
    for (size_t i = 0; i < count; i++)
        if (!is_own_variable(environ[i])) made[used++] = environ[i]; // without those given to this process
    if (made[0] && made[1]) return made;
    free_environment(made);
    return NULL;
}

// Opens the log; a job that runs alone has it only as stdout and stderr.
static int add_files(const struct vw_child_params *params, posix_spawn_file_actions_t *files) {
    const int to_log = O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY;
    int count = (int)params->job_count, kept = count > 1 ? count : 0;
    int error = posix_spawn_file_actions_addopen(files, INPUT, "/dev/null", O_RDONLY, 0);
    for (int i = 0; i < count && !error; i++)
        error = posix_spawn_file_actions_addopen(files, VW_CHILD_LOG + i, params->log_paths[i], to_log, 0666);
    if (!error) error = posix_spawn_file_actions_adddup2(files, VW_CHILD_LOG, OUTPUT);
    if (!error) error = posix_spawn_file_actions_adddup2(files, VW_CHILD_LOG, ERRORS);
    return error ? error : posix_spawn_file_actions_addclosefrom_np(files, VW_CHILD_LOG + kept);
}

static int spawn(const struct vw_child_params *params, char *const *environment, pid_t *process) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    int error = posix_spawn_file_actions_init(&files);
    if (error) return error;
    error = posix_spawnattr_init(&attributes);
    if (!error) {
        error = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
        if (!error) error = add_files(params, &files);
        if (!error) error = posix_spawn(process, params->program, &files, &attributes, params->words, environment);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&files);
    return error;
}

enum vw_status vw_child_start(const struct vw_child_params *params, pid_t *process) {
    char **environment = make_environment(params->seeds);
    if (!environment) return VW_ERROR_MEMORY;
    int error = spawn(params, environment, process);
    free_environment(environment);
    if (!error) return VW_OK;
    return vw_fail(VW_ERROR_IO, "%s: cannot start a process that writes there: %s; check the folder",
                   params->log_paths[0], strerror(error));
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

// Reads to the end, so that a full pipe does not stop the writer.
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
