// Status codes, error messages, and the conventions of the library.
//
// Conventions (a header notes only its exceptions):
// - A function that can fail returns enum vw_status. Results are returned through trailing pointers, which are
//   unchanged after a failure.
// - A failing function records one message with vw_fail(). Callers return the status, or add context with
//   vw_fail_context().
// - A params struct needs to live only during the call. A field that is zero has its documented default.
// - vw_x_create and vw_x_open give the caller an object that vw_x_destroy(&object) or vw_x_close(&object) frees. These
//   accept NULL, and set the pointer to NULL.
// - Strings are UTF-8 and borrowed unless a comment says "owned".
// - An object may be used by one thread at a time.
#ifndef VIEWWORTH_STATUS_H
#define VIEWWORTH_STATUS_H

#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum vw_status {
    VW_OK = 0,
    VW_ERROR_USAGE,       // a param, an option or a config value is wrong; exit code 2
    VW_ERROR_INPUT,       // a scene, list or image is missing or wrong; exit code 2
    VW_ERROR_NO_DEVICE,   // no suitable Vulkan device; exit code 2
    VW_ERROR_IO,          // reading or writing failed at run time; exit code 1
    VW_ERROR_MEMORY,      // out of host or device memory; exit code 1
    VW_ERROR_DEVICE,      // a Vulkan call failed, or a validation layer complained; exit code 1
    VW_ERROR_DEVICE_LOST, // the device no longer responds; exit code 1
    VW_ERROR_INTERRUPTED, // the user asked to stop; recorded steps are kept; exit code 1
    VW_ERROR_MISMATCH,    // a ledger differs from its hashes, from an expected chain head or from a replay; exit code 1
};

// Records a one-line message (file, line or field, and the remedy) for this thread and returns `status`, which must not
// be VW_OK. It replaces the message before.
enum vw_status vw_fail(enum vw_status status, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Puts "<formatted>: " before the recorded message and returns `status`.
enum vw_status vw_fail_context(enum vw_status status, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Macros for clang's analyzer, which does not see that the status of a failure is never VW_OK.
#ifdef __clang_analyzer__
#define vw_fail(status, ...) (vw_fail(status, __VA_ARGS__), (status))
#define vw_fail_context(status, ...) (vw_fail_context(status, __VA_ARGS__), (status))
#endif

// Replaces line ends, other control characters, changes of the writing direction and invalid UTF-8 by '?', in place, so
// that a name from a file cannot break the line, control the terminal or pass for another one. All messages and log
// lines have passed it.
void vw_text_make_line(char *text);

// Returns the message of this thread's last failure; "" if there was none. It is valid until the next failure of this
// thread.
const char *vw_error_message(void);

// Saves and restores the recorded message around a clean-up that may itself fail, so that the first failure is
// reported.
enum { VW_ERROR_MESSAGE_BYTES = 1024 };
struct vw_saved_error {
    char message[VW_ERROR_MESSAGE_BYTES];
};
struct vw_saved_error vw_error_save(void);
void vw_error_restore(const struct vw_saved_error *kept);

// The first failure of several pieces of work, with its message. All zero: none has failed.
struct vw_first_failure {
    enum vw_status status;
    struct vw_saved_error why;
};
// Keeps a failure and its message unless an earlier one is kept.
void vw_first_failure_note(struct vw_first_failure *failure, enum vw_status status);
// Returns the kept status and makes its message the recorded one again.
enum vw_status vw_first_failure_report(const struct vw_first_failure *failure);

// Returns the program's exit code for a status: 0 done, 1 failed at run time, 2 wrong usage or input.
int vw_exit_code(enum vw_status status);

VW_PUBLIC_END

#endif
