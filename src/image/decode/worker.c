#include <errno.h>
#include <fcntl.h>
#include <seccomp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"
#include "image/decode/oiio_shim.h"
#include "image/decode/tasks.h"
#include "image/photo_formats.h"
#include "image/pixel.h"

// ---- The confinement -----------------------------------------------------------------------------------------------

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

// ---- Messages ----

ssize_t vw_worker_receive(int socket, void *data, size_t size_bytes, int *descriptor) {
    union {
        char bytes[CMSG_SPACE(sizeof(int))];
        struct cmsghdr aligned;
    } control;
    struct iovec part = {data, size_bytes};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
    ssize_t got;
    do got = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
    while (got < 0 && errno == EINTR);
    const struct cmsghdr *header = got > 0 ? CMSG_FIRSTHDR(&message) : NULL;
    if (header && header->cmsg_level == SOL_SOCKET && header->cmsg_type == SCM_RIGHTS)
        memcpy(descriptor, CMSG_DATA(header), sizeof *descriptor);
    return got;
}

static bool read_all(void *data, size_t size_bytes) {
    for (size_t used = 0; used < size_bytes;) {
        ssize_t got = read(VW_DECODER_SOCKET, (char *)data + used, size_bytes - used);
        if (got <= 0) return false;
        used += (size_t)got;
    }
    return true;
}

static bool write_all(const void *data, size_t size_bytes) {
    for (size_t used = 0; used < size_bytes;) {
        ssize_t put = write(VW_DECODER_SOCKET, (const char *)data + used, size_bytes - used);
        if (put <= 0) return false;
        used += (size_t)put;
    }
    return true;
}

// ---- Tasks ----

// Maps the file instead of reading it: only the parts that a decoder uses take memory. If the file is shortened
// meanwhile, the kernel ends this process.
static bool read_file(const struct vw_decoder_request *request, int descriptor) {
    struct vw_decoder_answer answer;
    struct vw_image image = {0};
    struct stat info;
    void *file = MAP_FAILED;
    if (!fstat(descriptor, &info) && info.st_size > 0)
        file = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (file == MAP_FAILED) vw_task_fail(VW_ERROR_IO, "the file cannot be mapped into memory", &answer);
    else if (request->task == VW_DECODER_READ_HEADER) vw_task_read_header(request, file, (size_t)info.st_size, &answer);
    else vw_task_read_photo(request, file, (size_t)info.st_size, &answer, &image);
    bool written = write_all(&answer, sizeof answer);
    if (written && image.pixels) {
        size_t pixel_count = (size_t)image.width_px * image.height_px;
        written = write_all(image.pixels, pixel_count * 4 * vw_pixel_channel_bytes(image.format)) &&
                  (!image.unusable || write_all(image.unusable, pixel_count));
    }
    vw_image_clear(&image);
    if (file != MAP_FAILED) munmap(file, (size_t)info.st_size);
    return written;
}

static bool write_file(const struct vw_decoder_request *request) {
    const struct vw_image_header *header = &request->header;
    struct vw_decoder_answer answer = {0};
    size_t pixels_bytes = (size_t)header->width_px * header->height_px * header->channels * sizeof(float);
    float *pixels = malloc(pixels_bytes);
    void *file = NULL;
    bool written = pixels && read_all(pixels, pixels_bytes);
    if (written) {
        vw_task_write_photo(request, pixels, &answer, &file);
        written = write_all(&answer, sizeof answer) && write_all(file, answer.payload_bytes);
    }
    free(pixels);
    free(file);
    return written;
}

bool vw_worker_run(const struct vw_decoder_order *order) {
    const struct vw_confinement confinement = {
        .memory_bytes = order->memory_bytes, .cpu_s = order->cpu_s, .descriptor_most = VW_DECODER_SOCKET + 1};
    if (!vw_oiio_prepare_worker() || !vw_confine(&confinement)) return false;
    for (;;) {
        struct vw_decoder_request request;
        int descriptor = -1;
        ssize_t got = vw_worker_receive(VW_DECODER_SOCKET, &request, sizeof request, &descriptor);
        if (got <= 0) return !got;
        if ((size_t)got < sizeof request && !read_all((char *)&request + got, sizeof request - (size_t)got))
            return false;
        if (request.photo_format >= VW_PHOTO_FORMAT_COUNT) return false;
        if (request.task == VW_DECODER_WRITE_PHOTO ? !write_file(&request) : !read_file(&request, descriptor))
            return false;
        if (descriptor >= 0) close(descriptor);
    }
}
