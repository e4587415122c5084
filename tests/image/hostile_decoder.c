// Stands in for viewworth-decode in test_decoder.c, as if a photo had taken a worker over: the text after the signature
// of the photo says what it does.
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "image/decoder_protocol.h"

enum { PNG_SIGNATURE_BYTES = 8, SIDE_PX = 4, PIXEL_COUNT = SIDE_PX * SIDE_PX };

static ssize_t receive(int socket, void *data, size_t size_bytes, int *descriptor) {
    union {
        char bytes[CMSG_SPACE(sizeof(int))];
        struct cmsghdr aligned;
    } control;
    struct iovec part = {data, size_bytes};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
    ssize_t got = recvmsg(socket, &message, 0);
    struct cmsghdr *header = got > 0 ? CMSG_FIRSTHDR(&message) : NULL;
    if (header) memcpy(descriptor, CMSG_DATA(header), sizeof *descriptor);
    return got;
}

static void put(int socket, const void *data, size_t size_bytes) {
    if (send(socket, data, size_bytes, MSG_NOSIGNAL) != (ssize_t)size_bytes) _exit(1);
}

// Reports what the process has been given.
static void describe(struct vw_decoder_answer *answer) {
    size_t used = 0;
    sigset_t blocked;
    answer->status = VW_ERROR_IO;
    sigprocmask(SIG_BLOCK, NULL, &blocked);
    for (int descriptor = 0; descriptor < 100; descriptor++) {
        char link[64], target[64];
        snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
        used += readlink(link, target, sizeof target) > 0;
    }
    int length = snprintf(answer->message, sizeof answer->message, "%zu descriptors; %sinterruptible;", used,
                          sigismember(&blocked, SIGINT) ? "not " : "");
    for (char **variable = environ; *variable; variable++)
        length += snprintf(answer->message + length, sizeof answer->message - (size_t)length, " [%s]", *variable);
}

static bool is(const char *text, const char *word) { return !strcmp(text, word); }

static void answer_header(int socket, const char *text) {
    struct vw_decoder_answer answer = {.header = {SIDE_PX, SIDE_PX, 3, VW_PIXEL_UINT8}};
    if (is(text, "nan") || is(text, "above 1")) answer.header.format = VW_PIXEL_FLOAT32;
    if (is(text, "no width")) answer.header.width_px = 0;
    if (is(text, "no format")) memset(&answer.header.format, 0x7f, sizeof answer.header.format);
    if (is(text, "many pixels")) answer.header.width_px = answer.header.height_px = UINT32_MAX;
    if (is(text, "many values")) answer.header.width_px = answer.header.height_px = 16384, answer.header.channels = 64;
    if (is(text, "many channels")) answer.header.channels = 65;
    if (is(text, "crash at the header")) abort();
    if (is(text, "what it has")) describe(&answer);
    put(socket, &answer, sizeof answer);
}

static void answer_photo(int socket, const char *text) {
    bool floats = is(text, "nan") || is(text, "above 1");
    struct vw_decoder_answer answer = {.header = {SIDE_PX, SIDE_PX, 4, floats ? VW_PIXEL_FLOAT32 : VW_PIXEL_UINT8},
                                       .has_alpha = 2};
    float values[4 * PIXEL_COUNT] = {0};
    uint8_t unusable[PIXEL_COUNT] = {7};
    size_t pixels_bytes = 4 * PIXEL_COUNT * (floats ? sizeof(float) : 1);
    answer.masked_count = is(text, "unusable");
    answer.payload_bytes = pixels_bytes + (answer.masked_count ? PIXEL_COUNT : 0);
    memset(values, 0, sizeof values);
    if (is(text, "nan")) memset(&values[5], 0xff, sizeof values[5]);
    if (is(text, "above 1")) values[7] = 2;
    if (is(text, "crash")) abort();
    if (is(text, "hang")) pause();
    if (is(text, "half an answer")) put(socket, &answer, sizeof answer / 2), _exit(0);
    if (is(text, "a drop at a time"))
        for (size_t i = 0; i < sizeof answer; i++) put(socket, (char *)&answer + i, 1), poll(NULL, 0, 100);
    if (is(text, "another size")) answer.header.width_px++;
    if (is(text, "large payload")) answer.payload_bytes = UINT64_MAX;
    if (is(text, "unknown status")) answer.status = 77;
    if (is(text, "endless message")) {
        answer.status = VW_ERROR_IO;
        memset(answer.message, '\n', sizeof answer.message);
    }
    put(socket, &answer, sizeof answer);
    if (is(text, "half the pixels")) put(socket, values, pixels_bytes / 2), _exit(0);
    put(socket, values, pixels_bytes);
    if (answer.masked_count) put(socket, unusable, sizeof unusable);
    if (is(text, "more than asked")) put(socket, &answer, sizeof answer);
}

static void work(int socket) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (;;) {
        struct vw_decoder_request request;
        char text[64] = "";
        int photo = -1;
        if (receive(socket, &request, sizeof request, &photo) != (ssize_t)sizeof request) _exit(0);
        if (photo < 0 || pread(photo, text, sizeof text - 1, PNG_SIGNATURE_BYTES) < 0) _exit(1);
        if (request.task == VW_DECODER_READ_HEADER) answer_header(socket, text);
        else answer_photo(socket, text);
        close(photo);
    }
}

int main(void) {
    struct vw_decoder_order order;
    int socket = -1;
    put(VW_DECODER_SOCKET, VW_DECODER_HELLO, sizeof VW_DECODER_HELLO);
    while (receive(VW_DECODER_SOCKET, &order, sizeof order, &socket) == (ssize_t)sizeof order) {
        if (!fork()) work(socket);
        close(socket);
    }
    return 0;
}
