// The only C++ file, and the only one that uses OpenImageIO.
#include "image/oiio_shim.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <vector>

namespace {

struct failure {
    vw_status status;
    std::string message;
};

std::string or_else(const std::string &text, const char *fallback) { return text.empty() ? fallback : text; }

void *allocate(size_t size_bytes) {
    void *memory = std::malloc(size_bytes);
    if (!memory) throw std::bad_alloc();
    return memory;
}

// libpng writes its errors to stderr too; this keeps it to our one line. The first user redirects stderr and the last
// one restores it, whatever thread they are of.
class quiet_stderr {
  public:
    quiet_stderr() {
        std::lock_guard<std::mutex> lock(mutex);
        if (users++ > 0) return;
        kept = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
        int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
        if (kept >= 0 && nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
        if (nowhere >= 0) ::close(nowhere);
    }
    ~quiet_stderr() {
        std::lock_guard<std::mutex> lock(mutex);
        if (--users > 0 || kept < 0) return;
        ::dup2(kept, STDERR_FILENO);
        ::close(kept);
    }
    quiet_stderr(const quiet_stderr &) = delete;
    quiet_stderr &operator=(const quiet_stderr &) = delete;

  private:
    static inline std::mutex mutex;
    static inline int users = 0, kept = -1;
};

// Runs `work` on an empty result and converts exceptions into a status and a message.
template <typename Work> vw_oiio_result guard(Work work) {
    vw_oiio_result result{};
    std::string message;
    try {
        quiet_stderr quiet;
        work(result);
        return result;
    } catch (const failure &problem) {
        result.status = problem.status;
        message = problem.message;
    } catch (const std::bad_alloc &) {
        result.status = VW_ERROR_MEMORY;
        message = "out of memory; use --downscale or close other programs";
    } catch (const std::exception &problem) {
        result.status = VW_ERROR_IO;
        message = problem.what();
    } catch (...) {
        result.status = VW_ERROR_IO;
        message = "unknown failure in OpenImageIO";
    }
    std::free(result.data);
    result.data = nullptr;
    for (char &letter : message)
        if (letter == '\n' || letter == '\r') letter = ' ';
    std::strncpy(result.message, message.c_str(), sizeof result.message - 1);
    return result;
}

vw_pixel_format pixel_format(OIIO::TypeDesc type) {
    switch (type.basetype) {
    case OIIO::TypeDesc::UINT8: return VW_PIXEL_UINT8;
    case OIIO::TypeDesc::UINT16: return VW_PIXEL_UINT16;
    case OIIO::TypeDesc::HALF:
    case OIIO::TypeDesc::FLOAT:
    case OIIO::TypeDesc::DOUBLE: return VW_PIXEL_FLOAT32;
    default:
        throw failure{VW_ERROR_INPUT, std::string("pixels of type ") + type.c_str() +
                                          "; convert it to 8 or 16 bit integers or to float"};
    }
}

OIIO::TypeDesc type_desc(vw_pixel_format format) {
    return format == VW_PIXEL_UINT8    ? OIIO::TypeDesc::UINT8
           : format == VW_PIXEL_UINT16 ? OIIO::TypeDesc::UINT16
                                       : OIIO::TypeDesc::FLOAT;
}

void find_channels(const OIIO::ImageSpec &spec, int rgba_channel[4]) {
    static const char *const names[3] = {"R", "G", "B"};
    bool grey = spec.nchannels < 3;
    for (int i = 0; i < 3; i++) {
        int named = spec.channelindex(names[i]);
        rgba_channel[i] = named >= 0 ? named : grey ? 0 : i;
    }
    rgba_channel[3] = spec.alpha_channel;
}

std::unique_ptr<OIIO::ImageInput> open_header(const char *path, vw_oiio_result &result) {
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1; // do not premultiply
    std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path, &config);
    if (!input) throw failure{VW_ERROR_INPUT, or_else(OIIO::geterror(), "not an image that OpenImageIO can read")};
    const OIIO::ImageSpec &spec = input->spec();
    if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1 || spec.nchannels < 1)
        throw failure{VW_ERROR_INPUT, "not a plain two-dimensional image"};
    result.width_px = static_cast<uint32_t>(spec.width);
    result.height_px = static_cast<uint32_t>(spec.height);
    result.channels = static_cast<uint32_t>(spec.nchannels);
    result.format = pixel_format(spec.format);
    find_channels(spec, result.rgba_channel);
    result.premultiplied = spec.alpha_channel >= 0 && !spec.get_int_attribute("oiio:UnassociatedAlpha", 0);
    return input;
}

} // namespace

extern "C" vw_oiio_result vw_oiio_probe(const char *path) {
    return guard([&](vw_oiio_result &result) { open_header(path, result); });
}

extern "C" vw_oiio_result vw_oiio_read(const char *path) {
    return guard([&](vw_oiio_result &result) {
        std::unique_ptr<OIIO::ImageInput> input = open_header(path, result);
        OIIO::TypeDesc type = type_desc(result.format);
        result.size_bytes = static_cast<size_t>(result.width_px) * result.height_px * result.channels * type.size();
        result.data = allocate(result.size_bytes);
        bool complete = input->read_image(0, 0, 0, static_cast<int>(result.channels), type, result.data);
        if (!complete || input->has_error())
            throw failure{VW_ERROR_IO, or_else(input->geterror(), "the pixels cannot be read")};
    });
}

extern "C" vw_oiio_result vw_oiio_resize(const float *rgba, uint32_t width_px, uint32_t height_px,
                                         uint32_t new_width_px, uint32_t new_height_px) {
    return guard([&](vw_oiio_result &result) {
        OIIO::ImageSpec from(static_cast<int>(width_px), static_cast<int>(height_px), 4, OIIO::TypeDesc::FLOAT);
        OIIO::ImageSpec to(static_cast<int>(new_width_px), static_cast<int>(new_height_px), 4, OIIO::TypeDesc::FLOAT);
        result.size_bytes = static_cast<size_t>(new_width_px) * new_height_px * 4 * sizeof(float);
        result.data = allocate(result.size_bytes);
        OIIO::ImageBuf source(from, const_cast<float *>(rgba)); // wrapped, only read
        OIIO::ImageBuf target(to, result.data);
        if (!OIIO::ImageBufAlgo::resize(target, source, "lanczos3"))
            throw failure{VW_ERROR_IO, or_else(target.geterror(), "resizing failed")};
        result.width_px = new_width_px;
        result.height_px = new_height_px;
        result.channels = 4;
        result.format = VW_PIXEL_FLOAT32;
    });
}

extern "C" vw_oiio_result vw_oiio_encode(const char *path, uint32_t width_px, uint32_t height_px, uint32_t channels,
                                         bool eight_bit, const char *compression, const float *pixels) {
    return guard([&](vw_oiio_result &result) {
        std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path);
        if (!output) throw failure{VW_ERROR_USAGE, or_else(OIIO::geterror(), "unknown image format")};
        OIIO::Filesystem::IOVecOutput memory;
        if (!output->supports("ioproxy") || !output->set_ioproxy(&memory))
            throw failure{VW_ERROR_USAGE, "this image format cannot be written; use .png or .exr"};
        OIIO::ImageSpec spec(static_cast<int>(width_px), static_cast<int>(height_px), static_cast<int>(channels),
                             eight_bit ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT);
        spec["oiio:ColorSpace"] = eight_bit ? "sRGB" : "Linear";
        if (channels == 4 && eight_bit) spec["oiio:UnassociatedAlpha"] = 1;
        if (compression) spec["Compression"] = compression;
        if (!output->open(path, spec) || !output->write_image(OIIO::TypeDesc::FLOAT, pixels) || !output->close())
            throw failure{VW_ERROR_IO, or_else(output->geterror(), "encoding failed")};
        result.size_bytes = memory.buffer().size();
        result.data = allocate(result.size_bytes);
        std::memcpy(result.data, memory.buffer().data(), result.size_bytes);
    });
}
