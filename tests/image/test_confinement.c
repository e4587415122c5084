// The rights that a confined process still has, tried from inside.
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/memory.h"
#include "image/decode/tasks.h"
#include "support/cmocka_test.h"

#if defined(__SANITIZE_ADDRESS__)
static const bool sanitized = true; // the address sanitizer lifts the limit on memory
#else
static const bool sanitized = false;
#endif

// ---- Attempts: whether the process can do it ------------------------------------------------------------------------

static bool opens_a_file(void) { return open("/etc/passwd", O_RDONLY) >= 0; }
static bool creates_a_file(void) { return open("confinement.txt", O_WRONLY | O_CREAT, 0600) >= 0; }
static bool opens_the_network(void) { return socket(AF_INET, SOCK_STREAM, 0) >= 0; }
static bool opens_a_local_socket(void) { return socket(AF_UNIX, SOCK_STREAM, 0) >= 0; }
static bool duplicates_a_descriptor(void) { return dup(STDOUT_FILENO) >= 0; }
static bool dumps_core(void) { return prctl(PR_GET_DUMPABLE) == 1; }
static bool takes_memory(void) {
    void *memory = mmap(NULL, (size_t)1 << 30, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return memory != MAP_FAILED;
}
static bool takes_a_little_memory(void) {
    volatile char *memory = malloc(1 << 20);
    if (memory) memory[12345] = 1;
    return memory;
}
static bool forks(void) {
    pid_t child = fork();
    if (!child) _exit(0);
    return child > 0;
}
static bool becomes_a_program(void) {
    char *const arguments[] = {"/bin/true", NULL};
    execv(arguments[0], arguments);
    return false; // and true, the exit code 0, if it does
}
static bool signals_its_parent(void) { return !kill(getppid(), 0); }
static bool traces(void) { return !ptrace(PTRACE_TRACEME, 0, NULL, NULL); }
static bool makes_memory_code(void) {
    return mmap(NULL, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
}
static bool becomes_dumpable(void) { return !prctl(PR_SET_DUMPABLE, 1, 0, 0, 0); }

struct attempt {
    const char *what;
    bool (*succeeds)(void);
    bool by_seccomp; // only that denies it
    bool is_allowed;
};

static const struct attempt attempts[] = {
    {"opens a file", opens_a_file, false, false},
    {"creates a file", creates_a_file, false, false},
    {"opens the network", opens_the_network, false, false},
    {"opens a local socket", opens_a_local_socket, false, false},
    {"duplicates a descriptor", duplicates_a_descriptor, false, false},
    {"takes a little memory", takes_a_little_memory, false, true},
    {"forks", forks, true, false}, // the limit on processes does not hold for root
    {"becomes a program", becomes_a_program, true, false},
    {"signals its parent", signals_its_parent, true, false},
    {"traces", traces, true, false},
    {"makes memory code", makes_memory_code, true, false},
    {"becomes dumpable", becomes_dumpable, true, false},
};

// Returns the status of a process that is confined and then makes one attempt: its exit code is 0 if that succeeds.
static int attempt_confined(bool (*succeeds)(void), const struct vw_confinement *confinement) {
    pid_t child = fork();
    assert_true(child >= 0);
    if (!child) {
        closefrom(3);
        if (!vw_confine(confinement)) _exit(99);
        _exit(succeeds() ? 0 : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return status;
}

static const struct vw_confinement usual = {.memory_bytes = 64 << 20, .cpu_s = 10, .descriptor_most = 2};

static void check_attempts(bool without_seccomp) {
    struct vw_confinement confinement = usual;
    confinement.without_seccomp = without_seccomp;
    for (size_t i = 0; i < VW_ARRAY_COUNT(attempts); i++) {
        if (without_seccomp && attempts[i].by_seccomp) continue;
        int status = attempt_confined(attempts[i].succeeds, &confinement);
        if (!WIFEXITED(status)) fail_msg("%s: ended by signal %d", attempts[i].what, WTERMSIG(status));
        if (WEXITSTATUS(status) != !attempts[i].is_allowed)
            fail_msg("%s: exit code %d", attempts[i].what, WEXITSTATUS(status));
    }
}

TEST(rights_are_gone) {
    assert_int_equal(access("/proc/sys/kernel/seccomp", F_OK), 0); // the kernel has seccomp
    check_attempts(false);
}

TEST(limits_hold_without_seccomp) { check_attempts(true); }

TEST(memory_is_limited) {
    if (sanitized) skip();
    assert_int_equal(WEXITSTATUS(attempt_confined(takes_memory, &usual)), 1);
}

TEST(no_core_is_dumped) {
    struct vw_confinement confinement = usual;
    confinement.without_seccomp = true; // which denies the question
    assert_int_equal(WEXITSTATUS(attempt_confined(dumps_core, &confinement)), 1);
}

static bool computes_for_ever(void) {
    volatile bool going_on = true;
    while (going_on) {
    }
    return true;
}

TEST(time_is_limited) {
    struct vw_confinement confinement = usual;
    confinement.cpu_s = 1;
    int status = attempt_confined(computes_for_ever, &confinement);
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), SIGKILL);
}
