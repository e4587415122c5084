// Makes calls of the C library fail, for scripts/faults: preloaded (LD_PRELOAD) before a program that knows nothing of
// it. What fails is chosen by the environment; numbers count from 1.
//
//     FAULT_LOG=FILE         every call that may fail is a line of FILE: its number, kind and path or place
//     FAULT_FOLDER=FOLDER    the calls that change files in this folder are counted, and one of them is hit:
//     FAULT_FILE=N           the one with this number
//     FAULT_ERROR=NUMBER     by failing with this errno;
//     FAULT_REPEAT=1         by failing, as do all later ones: a disk that is full (on which files can be removed);
//     FAULT_SIGNAL=NUMBER    by sending this signal to the process when half of the bytes are written
//     FAULT_SYNC_MS=NUMBER   every sync takes so much longer: a slow disk
//     FAULT_SWAP=FILE        is moved to the path FAULT_SWAP_TO when that is opened for the FAULT_SWAP_ATth time
//     FAULT_MEMORY=PLACE     the first allocation from this place returns NULL; FAULT_MEMORY=list logs all places. A
//     place
//                            is the hash of the callers in the program, SQLite and jansson: what a driver allocates
//                            never fails
//     FAULT_CLOCK=SECONDS    the clock jumps by so much,
//     FAULT_CLOCK_AFTER=N    when the program has read it so often,
//     FAULT_CLOCK_STEADY=1   and so does the clock that should never jump
//     FAULT_SLEEP=1          the program and SQLite wait for nothing: a lock that takes a minute to give up is asked as
//                            often in no time
#undef _FORTIFY_SOURCE // which defines the functions below in its own way
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

// ---- Settings ------------------------------------------------------------------------------------------------------

static struct {
    const char *folder, *memory, *swap, *swap_to;
    long file, error, signal, sync_ms, swap_at, clock_s, clock_after;
    bool repeat, steady, sleep, ready;
    int log;
} fault;

static long read_number(const char *name) {
    const char *text = getenv(name);
    return text ? strtol(text, NULL, 10) : 0;
}

__attribute__((format(printf, 1, 2))) static void write_log(const char *format, ...) {
    char line[PATH_MAX + 64];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    if (fault.log >= 0 && length > 0) syscall(SYS_write, fault.log, line, (size_t)length);
}

// ---- Who calls -----------------------------------------------------------------------------------------------------

enum { OBJECTS_MAX = 8, FRAMES_MAX = 24, PLACE_FRAMES = 3 };

// The program, SQLite and jansson; and what is only passed through on the way to them: the C library and this file.
static struct object {
    uintptr_t first, last;
    bool passed_through;
} objects[OBJECTS_MAX];
static uint32_t object_count;
static __thread bool inside __attribute__((tls_model("initial-exec"))); // unwinding: allocations do not count

static int note_object(struct dl_phdr_info *info, size_t size_bytes, void *context) {
    (void)size_bytes;
    struct object object = {.first = info->dlpi_addr};
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *header = &info->dlpi_phdr[i];
        if (header->p_type == PT_LOAD) object.last = info->dlpi_addr + header->p_vaddr + header->p_memsz;
    }
    uintptr_t here = (uintptr_t)context;
    const char *name = info->dlpi_name;
    object.passed_through = strstr(name, "/libc.so") || (here >= object.first && here < object.last);
    bool wanted = object.passed_through || !*name || strstr(name, "/libsqlite3.so") || strstr(name, "/libjansson.so");
    if (wanted && object_count < OBJECTS_MAX) objects[object_count++] = object;
    return 0;
}

static const struct object *find_object(const void *address) {
    uintptr_t at = (uintptr_t)address;
    for (uint32_t i = 0; i < object_count; i++)
        if (at >= objects[i].first && at < objects[i].last) return &objects[i];
    return NULL;
}

static bool is_ours(const void *address) {
    const struct object *object = find_object(address);
    return object && !object->passed_through;
}

// Hashes the first callers that are ours; 0 when another one called the C library.
static uint64_t find_place(void) {
    void *frames[FRAMES_MAX];
    uint64_t hash = 14695981039346656037u;
    int used = 0, count = backtrace(frames, FRAMES_MAX), i = 0;
    while (i < count && find_object(frames[i]) && !is_ours(frames[i])) i++;
    if (i == count || !is_ours(frames[i])) return 0;
    for (; i < count && used < PLACE_FRAMES; i++) {
        if (!is_ours(frames[i])) continue;
        const struct object *object = find_object(frames[i]);
        hash = (hash ^ (uint64_t)(object - objects)) * 1099511628211u;
        hash = (hash ^ ((uintptr_t)frames[i] - object->first)) * 1099511628211u;
        used++;
    }
    return hash | 1;
}

__attribute__((constructor)) static void read_settings(void) {
    const char *log = getenv("FAULT_LOG");
    void *frames[2];
    fault.log = log ? (int)syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666) : -1;
    fault.folder = getenv("FAULT_FOLDER");
    fault.memory = getenv("FAULT_MEMORY");
    fault.swap = getenv("FAULT_SWAP");
    fault.swap_to = getenv("FAULT_SWAP_TO");
    fault.swap_at = read_number("FAULT_SWAP_AT");
    fault.file = read_number("FAULT_FILE");
    fault.error = read_number("FAULT_ERROR");
    fault.signal = read_number("FAULT_SIGNAL");
    fault.sync_ms = read_number("FAULT_SYNC_MS");
    fault.repeat = read_number("FAULT_REPEAT");
    fault.clock_s = read_number("FAULT_CLOCK");
    fault.clock_after = read_number("FAULT_CLOCK_AFTER");
    fault.steady = read_number("FAULT_CLOCK_STEADY");
    fault.sleep = read_number("FAULT_SLEEP");
    dl_iterate_phdr(note_object, (void *)(uintptr_t)&find_place);
    backtrace(frames, 2); // the first call loads a library
    fault.ready = true;
}

// ---- Files ---------------------------------------------------------------------------------------------------------

static atomic_long file_count;

// Makes a path absolute by the folder it is relative to.
static void find_path(int folder, const char *path, char found[2 * PATH_MAX]) {
    char link[64], base[PATH_MAX] = "";
    if (path[0] != '/') {
        snprintf(link, sizeof link, folder == AT_FDCWD ? "/proc/self/cwd" : "/proc/self/fd/%d", folder);
        ssize_t length = readlink(link, base, sizeof base - 2);
        if (length > 0) strcpy(base + length, *path ? "/" : "");
    }
    snprintf(found, 2 * PATH_MAX, "%s%s", base, path);
}

enum outcome { PASSES, FAILS, SIGNALS };

static enum outcome next_file_call(const char *kind, int folder, const char *path) {
    char found[2 * PATH_MAX];
    if (!fault.ready || !fault.folder) return PASSES;
    int before = errno;
    find_path(folder, path, found);
    size_t length = strlen(fault.folder);
    errno = before;
    if (strncmp(found, fault.folder, length) || (found[length] && found[length] != '/')) return PASSES;
    long number = ++file_count;
    write_log("%ld %s %s\n", number, kind, found + length + (found[length] == '/'));
    if (number < fault.file || !fault.file || (number > fault.file && !fault.repeat)) return PASSES;
    if (fault.signal) return SIGNALS;
    if (fault.error == ENOSPC && !strcmp(kind, "unlink")) return PASSES;
    errno = (int)fault.error;
    return FAILS;
}

// Sends the signal to the process, as other senders do: the thread that writes the ledger takes none.
static void send_signal(void) { kill(getpid(), (int)fault.signal); }

// Returns whether a call that does all or nothing must fail.
static bool hits(const char *kind, int folder, const char *path) {
    enum outcome outcome = next_file_call(kind, folder, path);
    if (outcome == SIGNALS) send_signal();
    return outcome == FAILS;
}

static bool is_part_written(const char *kind, int file, enum outcome *outcome) {
    *outcome = next_file_call(kind, file, "");
    return *outcome == SIGNALS || (*outcome == FAILS && fault.repeat);
}

ssize_t pwrite(int file, const void *data, size_t size_bytes, off_t offset_bytes) {
    enum outcome outcome;
    if (is_part_written("pwrite", file, &outcome) && size_bytes > 1) {
        ssize_t written = syscall(SYS_pwrite64, file, data, size_bytes / 2, offset_bytes);
        if (outcome == FAILS) return written;
    }
    if (outcome == FAILS) return -1;
    if (outcome == SIGNALS) send_signal();
    return syscall(SYS_pwrite64, file, data, size_bytes, offset_bytes);
}

ssize_t write(int file, const void *data, size_t size_bytes) {
    enum outcome outcome;
    if (is_part_written("write", file, &outcome) && size_bytes > 1) {
        ssize_t written = syscall(SYS_write, file, data, size_bytes / 2);
        if (outcome == FAILS || written < 0) return written;
        send_signal(); // after which the rest is written, when the process goes on
        ssize_t rest = syscall(SYS_write, file, (const char *)data + written, size_bytes - (size_t)written);
        return rest < 0 ? rest : written + rest;
    }
    if (outcome == SIGNALS) send_signal();
    return outcome == FAILS ? -1 : syscall(SYS_write, file, data, size_bytes);
}

static int sync_slowly(const char *kind, long number, int file) {
    const struct timespec wait = {fault.sync_ms / 1000, fault.sync_ms % 1000 * 1000000};
    if (fault.sync_ms) syscall(SYS_nanosleep, &wait, NULL);
    return hits(kind, file, "") ? -1 : (int)syscall(number, file);
}

int fsync(int file) { return sync_slowly("fsync", SYS_fsync, file); }
int fdatasync(int file) { return sync_slowly("fdatasync", SYS_fdatasync, file); }

int ftruncate(int file, off_t size_bytes) {
    return hits("ftruncate", file, "") ? -1 : (int)syscall(SYS_ftruncate, file, size_bytes);
}

static void swap(int folder, const char *path) {
    static atomic_long count;
    char found[2 * PATH_MAX];
    if (!fault.ready || !fault.swap || !fault.swap_to) return;
    find_path(folder, path, found);
    if (strcmp(found, fault.swap_to) != 0 || ++count != fault.swap_at) return;
    syscall(SYS_renameat2, AT_FDCWD, fault.swap, AT_FDCWD, fault.swap_to, 0);
    write_log("%ld swap %s\n", (long)count, found);
}

// Replaces the call by which programs open files in ways that the C library lacks.
long syscall(long number, ...) {
    static long (*next)(long number, ...);
    long arguments[6];
    va_list list;
    va_start(list, number);
    for (int i = 0; i < 6; i++) arguments[i] = va_arg(list, long);
    va_end(list);
    if (!next) *(void **)&next = dlsym(RTLD_NEXT, "syscall");
    if (number == SYS_openat2) swap((int)arguments[0], (const char *)arguments[1]);
    return next(number, arguments[0], arguments[1], arguments[2], arguments[3], arguments[4], arguments[5]);
}

static int open_file(int folder, const char *path, int flags, mode_t mode) {
    swap(folder, path);
    if ((flags & O_CREAT) && hits("create", folder, path)) return -1;
    return (int)syscall(SYS_openat, folder, path, flags, mode);
}

static mode_t read_mode(int flags, va_list arguments) {
    return flags & (O_CREAT | __O_TMPFILE) ? va_arg(arguments, mode_t) : 0;
}

int open(const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = read_mode(flags, arguments);
    va_end(arguments);
    return open_file(AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = read_mode(flags, arguments);
    va_end(arguments);
    return open_file(folder, path, flags, mode);
}

typedef FILE *open_stream(const char *path, const char *mode);

FILE *fopen(const char *path, const char *mode) {
    static open_stream *next; // not a plain call: the C library opens by a function of its own
    if (!next) *(void **)&next = dlsym(RTLD_NEXT, "fopen");
    swap(AT_FDCWD, path);
    return next(path, mode);
}

int renameat2(int from_folder, const char *from, int to_folder, const char *to, unsigned flags) {
    if (hits("rename", to_folder, to)) return -1;
    return (int)syscall(SYS_renameat2, from_folder, from, to_folder, to, flags);
}

int renameat(int from_folder, const char *from, int to_folder, const char *to) {
    return renameat2(from_folder, from, to_folder, to, 0);
}

int rename(const char *from, const char *to) { return renameat2(AT_FDCWD, from, AT_FDCWD, to, 0); }

int linkat(int from_folder, const char *from, int to_folder, const char *to, int flags) {
    if (hits("link", to_folder, to)) return -1;
    return (int)syscall(SYS_linkat, from_folder, from, to_folder, to, flags);
}

int link(const char *from, const char *to) { return linkat(AT_FDCWD, from, AT_FDCWD, to, 0); }

int unlinkat(int folder, const char *path, int flags) {
    return hits("unlink", folder, path) ? -1 : (int)syscall(SYS_unlinkat, folder, path, flags);
}

int unlink(const char *path) { return unlinkat(AT_FDCWD, path, 0); }

int mkdirat(int folder, const char *path, mode_t mode) {
    return hits("mkdir", folder, path) ? -1 : (int)syscall(SYS_mkdirat, folder, path, mode);
}

int mkdir(const char *path, mode_t mode) { return mkdirat(AT_FDCWD, path, mode); }

// The names of the same functions for large files.
#define IS_ALSO(name) __attribute__((alias(#name)))
ssize_t pwrite64(int file, const void *data, size_t size_bytes, off64_t offset_bytes) IS_ALSO(pwrite);
int ftruncate64(int file, off64_t size_bytes) IS_ALSO(ftruncate);
int open64(const char *path, int flags, ...) IS_ALSO(open);
int openat64(int folder, const char *path, int flags, ...) IS_ALSO(openat);
FILE *fopen64(const char *path, const char *mode) IS_ALSO(fopen);

// ---- Memory --------------------------------------------------------------------------------------------------------

void *__libc_malloc(size_t size_bytes);
void *__libc_calloc(size_t count, size_t item_bytes);
void *__libc_realloc(void *memory, size_t size_bytes);
void *__libc_memalign(size_t alignment_bytes, size_t size_bytes);

// Returns whether a place is new, so that it is logged once; one that finds no room is logged again, which does no
// harm.
static bool is_new_place(uint64_t place) {
    enum { SLOTS = 1 << 14 };
    static _Atomic uint64_t known[SLOTS];
    for (uint64_t i = 0; i < 64; i++) {
        uint64_t none = 0;
        _Atomic uint64_t *slot = &known[(place / 2 + i) % SLOTS];
        if (atomic_compare_exchange_strong(slot, &none, place)) return true;
        if (none == place) return false;
    }
    return true;
}

static bool hits_memory(const void *caller) {
    static atomic_bool done;
    if (!fault.ready || !fault.memory || inside || done || !find_object(caller)) return false;
    inside = true;
    uint64_t place = find_place();
    char text[32];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)place);
    bool hit = place && !strcmp(text, fault.memory) && !atomic_exchange(&done, true);
    if (hit || (place && !strcmp(fault.memory, "list") && is_new_place(place))) write_log("0 memory %s\n", text);
    inside = false;
    if (hit) errno = ENOMEM;
    return hit;
}

void *malloc(size_t size_bytes) { return hits_memory(__builtin_return_address(0)) ? NULL : __libc_malloc(size_bytes); }
void *calloc(size_t count, size_t item_bytes) {
    return hits_memory(__builtin_return_address(0)) ? NULL : __libc_calloc(count, item_bytes);
}
void *realloc(void *memory, size_t size_bytes) {
    return hits_memory(__builtin_return_address(0)) ? NULL : __libc_realloc(memory, size_bytes);
}

void *reallocarray(void *memory, size_t count, size_t item_bytes) {
    size_t size_bytes;
    if (__builtin_mul_overflow(count, item_bytes, &size_bytes)) return errno = ENOMEM, NULL;
    return hits_memory(__builtin_return_address(0)) ? NULL : __libc_realloc(memory, size_bytes);
}

int posix_memalign(void **memory, size_t alignment_bytes, size_t size_bytes) {
    void *made = hits_memory(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment_bytes, size_bytes);
    if (made) *memory = made;
    return made ? 0 : ENOMEM;
}

// ---- Clocks --------------------------------------------------------------------------------------------------------

static long clock_jump_s(clockid_t clock, const void *caller) {
    static atomic_long count;
    if (!fault.clock_s) return 0;
    bool ours = is_ours(caller), steady = clock != CLOCK_REALTIME && clock != CLOCK_REALTIME_COARSE;
    if (ours) count++;
    if (count <= fault.clock_after || (steady && !(ours && fault.steady && clock == CLOCK_MONOTONIC))) return 0;
    return fault.clock_s;
}

int clock_gettime(clockid_t clock, struct timespec *now) {
    int result = (int)syscall(SYS_clock_gettime, clock, now);
    if (!result) now->tv_sec += clock_jump_s(clock, __builtin_return_address(0));
    return result;
}

time_t time(time_t *now_s) {
    struct timespec now;
    syscall(SYS_clock_gettime, CLOCK_REALTIME, &now);
    now.tv_sec += clock_jump_s(CLOCK_REALTIME, __builtin_return_address(0));
    if (now_s) *now_s = now.tv_sec;
    return now.tv_sec;
}

static bool skips_sleep(const void *caller) {
    bool skips = fault.sleep && is_ours(caller);
    if (skips) write_log("0 sleep\n");
    return skips;
}

int nanosleep(const struct timespec *duration, struct timespec *left) {
    return skips_sleep(__builtin_return_address(0)) ? 0 : (int)syscall(SYS_nanosleep, duration, left);
}

int usleep(useconds_t duration_us) {
    const struct timespec duration = {duration_us / 1000000, duration_us % 1000000 * 1000};
    return skips_sleep(__builtin_return_address(0)) ? 0 : (int)syscall(SYS_nanosleep, &duration, NULL);
}
