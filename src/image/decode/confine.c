#include <errno.h>
#include <fcntl.h>
#include <seccomp.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/memory.h"
#include "image/decode/tasks.h"

#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

// ---- Limits ----

static bool limit(__rlimit_resource_t resource, uint64_t most) {
    return !setrlimit(resource, &(struct rlimit){.rlim_cur = most, .rlim_max = most});
}

// Returns the address space that the process has now; 0: unknown.
static uint64_t used_bytes(void) {
    unsigned long pages = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (!file) return 0;
    if (fscanf(file, "%lu", &pages) != 1) pages = 0;
    (void)fclose(file);
    return (uint64_t)pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

// Limits the memory, except under the address sanitizer, which reserves terabytes. Without /proc, the part that the
// libraries take is guessed.
static bool limit_memory(uint64_t memory_bytes) {
    uint64_t used = used_bytes();
    return SANITIZED || limit(RLIMIT_AS, (used ? used : UINT64_C(1) << 30) + memory_bytes);
}

static bool limit_all(const struct vw_confinement *confinement) {
    return limit_memory(confinement->memory_bytes) && limit(RLIMIT_CPU, confinement->cpu_s) && limit(RLIMIT_CORE, 0) &&
           limit(RLIMIT_FSIZE, 0) && limit(RLIMIT_NPROC, 0) && limit(RLIMIT_MEMLOCK, 0) &&
           limit(RLIMIT_NOFILE, confinement->descriptor_most + 1);
}

// ---- System calls ----

// The system calls needed to read a mapped file, to allocate memory, and to use sockets that are open.
static const int allowed[] = {
    SCMP_SYS(read),        SCMP_SYS(write),        SCMP_SYS(recvmsg),         SCMP_SYS(close),
    SCMP_SYS(fstat),       SCMP_SYS(munmap),       SCMP_SYS(mremap),          SCMP_SYS(brk),
    SCMP_SYS(madvise),     SCMP_SYS(futex),        SCMP_SYS(sched_yield),     SCMP_SYS(clock_gettime),
    SCMP_SYS(getpid),      SCMP_SYS(gettid),       SCMP_SYS(gettimeofday),    SCMP_SYS(getrandom),
    SCMP_SYS(exit),        SCMP_SYS(exit_group),   SCMP_SYS(rt_sigprocmask),  SCMP_SYS(rt_sigaction),
    SCMP_SYS(sigaltstack), SCMP_SYS(rt_sigreturn), SCMP_SYS(restart_syscall),
};

// Allows calls with certain arguments: fstat() is newfstatat() of an empty path in newer C libraries; memory never
// becomes code.
static bool allow_some(scmp_filter_ctx filter) {
    return !seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(newfstatat), 1,
                             SCMP_A3(SCMP_CMP_MASKED_EQ, AT_EMPTY_PATH, AT_EMPTY_PATH)) &&
           !seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 1, SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0)) &&
           !seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 1,
                             SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0)) &&
           !seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1,
                             SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)getpid(), 0));
}

// Makes all other calls fail with EPERM, as if the process lacked the right: decoders then report an error. Returns
// false if a filter cannot be set although the kernel has them.
static bool filter_calls(void) {
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    bool complete = filter && allow_some(filter);
    for (size_t i = 0; complete && i < VW_ARRAY_COUNT(allowed); i++)
        complete = !seccomp_rule_add(filter, SCMP_ACT_ALLOW, allowed[i], 0);
    int failure = complete ? seccomp_load(filter) : -ENOMEM;
    if (filter) seccomp_release(filter);
    return !failure || failure == -EINVAL || failure == -ENOSYS; // the last two where the kernel has none
}

bool vw_confine(const struct vw_confinement *confinement) {
    return !prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) && !prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) && limit_all(confinement) &&
           (confinement->without_seccomp || filter_calls());
}
