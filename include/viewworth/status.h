// Status codes, the message of the last failure, and the conventions on ownership and lifetime.
//
// Conventions (each header notes only its exceptions):
// - Every function that can fail returns enum vw_status; results come back through trailing pointers, untouched on
// failure.
// - A failing function calls vw_fail() once, where it knows most; callers return the code, or add context with
// vw_fail_context().
// - A params struct needs to live only for the call. A field left zero means its stated default.
// - vw_x_create/open gives the caller an object that vw_x_destroy/close(&object) ends; these accept NULL and half-built
// objects
//   and set the pointer to NULL.
// - Strings are UTF-8, borrowed unless a comment says "owned". Objects are for one thread at a time.
#ifndef VIEWWORTH_STATUS_H
#define VIEWWORTH_STATUS_H

#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum vw_status {
    VW_OK = 0,
    VW_ERROR_USAGE,       // wrong command line or config value; exit code 2
    VW_ERROR_INPUT,       // a scene, list or image is wrong, missing or refused; exit code 2
    VW_ERROR_NO_DEVICE,   // no Vulkan device fits; exit code 2
    VW_ERROR_IO,          // reading or writing failed at run time; exit code 1
    VW_ERROR_MEMORY,      // host or device memory is short; exit code 1
    VW_ERROR_DEVICE,      // a Vulkan call failed, or a validation layer complained; exit code 1
    VW_ERROR_DEVICE_LOST, // the device stopped answering; exit code 1
    VW_ERROR_INTERRUPTED, // the user asked to stop; what was recorded is kept; exit code 1
    VW_ERROR_MISMATCH,    // a ledger disagrees with itself, with what was expected or with a replay; exit code 1
};

// Records a one-line message (file, line or field, and the remedy) for this thread and returns `status`.
// The newest message replaces an older one. `status` must not be VW_OK.
enum vw_status vw_fail(enum vw_status status, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Puts "<formatted>: " before the recorded message and returns `status` unchanged.
enum vw_status vw_fail_context(enum vw_status status, const char *format, ...) __attribute__((format(printf, 2, 3)));

// clang's analyzer does not see that what fails is never VW_OK.
#ifdef __clang_analyzer__
#define vw_fail(status, ...) (vw_fail(status, __VA_ARGS__), (status))
#define vw_fail_context(status, ...) (vw_fail_context(status, __VA_ARGS__), (status))
#endif

// Replaces line ends and other control characters by '?', in place: names come from files, and a message is one line
// that no name can break or use to command a terminal. vw_fail() and vw_fail_context() do it themselves.
void vw_text_make_line(char *text);

// The message of this thread's last failure, "" when there was none. Valid until the next failure of this thread.
const char *vw_error_message(void);

// Keeps the recorded message over a clean-up that may itself fail: what failed first is what the user has to know.
enum { VW_ERROR_MESSAGE_BYTES = 1024 };
struct vw_saved_error {
    char message[VW_ERROR_MESSAGE_BYTES];
};
struct vw_saved_error vw_error_save(void);
void vw_error_restore(const struct vw_saved_error *kept);

// The program's exit code for a status: 0 done, 1 failed at run time, 2 wrong usage or input.
int vw_exit_code(enum vw_status status);

VW_PUBLIC_END

#endif
