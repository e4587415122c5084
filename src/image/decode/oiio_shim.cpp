// The only C++ file, and the only one that uses OpenImageIO. It is linked into the program viewworth-decode alone.
#include "image/decode/oiio_shim.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <new>
#include <string>
#include <thread>
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

// Runs `work` on an empty result and converts exceptions into a status and a message.
template <typename Work> vw_oiio_result guard(Work work) {
    vw_oiio_result result{};
    std::string message;
    try {
        work(result);
        return result;
    } catch (const failure &problem) {
        result.status = problem.status;
        message = problem.message;
    } catch (const std::bad_alloc &) {
        result.status = VW_ERROR_MEMORY;
        message = "it needs more memory than an image of its size should";
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
    rgba_channel[3] = spec.alpha_channel < spec.nchannels ? spec.alpha_channel : -1;
}

// An open image, and the bytes it is read from.
struct image_file {
    OIIO::Filesystem::IOMemReader bytes; // outlives `input`
    std::unique_ptr<OIIO::ImageInput> input;
    image_file(const void *file, size_t file_bytes) : bytes(const_cast<void *>(file), file_bytes) {} // only read
};

// Opens a header under a constant name, so that no photo's name can become an option or another file.
void open_header(const char *plugin, image_file &file, vw_oiio_result &result) {
    OIIO::ImageSpec config, spec;
    config["oiio:UnassociatedAlpha"] = 1; // do not premultiply
    file.input = OIIO::ImageInput::create(plugin);
    if (!file.input || !file.input->supports("ioproxy") || !file.input->set_ioproxy(&file.bytes))
        throw failure{VW_ERROR_IO, "OpenImageIO was built without this format"};
    if (!file.input->open("photo", spec, config))
        throw failure{VW_ERROR_INPUT, or_else(file.input->geterror(), "not an image of its format")};
    if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1 || spec.nchannels < 1 || spec.deep)
        throw failure{VW_ERROR_INPUT, "not a plain two-dimensional image"};
    result.header.width_px = static_cast<uint32_t>(spec.width);
    result.header.height_px = static_cast<uint32_t>(spec.height);
    result.header.channels = static_cast<uint32_t>(spec.nchannels);
    result.header.format = pixel_format(spec.format);
    int orientation = spec.get_int_attribute("Orientation", 0);
    result.header.orientation = orientation >= 1 && orientation <= 8 ? static_cast<uint32_t>(orientation) : 0;
    find_channels(spec, result.rgba_channel);
    result.premultiplied = spec.alpha_channel >= 0 && !spec.get_int_attribute("oiio:UnassociatedAlpha", 0);
}

size_t count_threads() {
    std::error_code error;
    std::filesystem::directory_iterator tasks("/proc/self/task", error), end;
    return error ? 0 : static_cast<size_t>(std::distance(tasks, end));
}

bool is_same(const vw_image_header &a, const vw_image_header &b) {
    return a.width_px == b.width_px && a.height_px == b.height_px && a.channels == b.channels && a.format == b.format;
}

} // namespace

extern "C" void vw_oiio_prepare_server(void) {
    OIIO::attribute("exr_threads", -1); // none beside the caller
    OIIO::attribute("plugin_searchpath", "");
    (void)OIIO::ImageInput::create("png"); // registers all formats
}

extern "C" bool vw_oiio_prepare_worker(void) {
    size_t before = count_threads();
    OIIO::attribute("threads", 1); // starts as many threads as there are processors, and tells them to end
    for (int waited_ms = 0; waited_ms < 10000; waited_ms++) {
        if (count_threads() <= before) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
}

extern "C" vw_oiio_result vw_oiio_probe(const char *plugin, const void *bytes, size_t size_bytes) {
    return guard([&](vw_oiio_result &result) {
        image_file file(bytes, size_bytes);
        open_header(plugin, file, result);
    });
}

extern "C" vw_oiio_result vw_oiio_read(const char *plugin, const void *bytes, size_t size_bytes,
                                       const vw_image_header *expected) {
    return guard([&](vw_oiio_result &result) {
        image_file file(bytes, size_bytes);
        open_header(plugin, file, result);
        const vw_image_header &header = result.header;
        if (!is_same(header, *expected)) throw failure{VW_ERROR_IO, "its header changed while it was read"};
        OIIO::TypeDesc type = type_desc(header.format);
        result.size_bytes = static_cast<size_t>(header.width_px) * header.height_px * header.channels * type.size();
        result.data = allocate(result.size_bytes);
        bool complete = file.input->read_image(0, 0, 0, static_cast<int>(header.channels), type, result.data);
        if (!complete || file.input->has_error())
            throw failure{VW_ERROR_IO, or_else(file.input->geterror(), "the pixels cannot be read")};
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
        result.header = {new_width_px, new_height_px, 4, VW_PIXEL_FLOAT32, 0};
    });
}

extern "C" vw_oiio_result vw_oiio_encode(const char *plugin, const vw_image_header *header, bool eight_bit,
                                         const char *compression, const float *pixels) {
    return guard([&](vw_oiio_result &result) {
        std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(plugin);
        OIIO::Filesystem::IOVecOutput memory;
        if (!output || !output->supports("ioproxy") || !output->set_ioproxy(&memory))
            throw failure{VW_ERROR_USAGE, "this image format cannot be written; use .png or .exr"};
        int channels = static_cast<int>(header->channels);
        OIIO::ImageSpec spec(static_cast<int>(header->width_px), static_cast<int>(header->height_px), channels,
                             eight_bit ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT);
        spec["oiio:ColorSpace"] = eight_bit ? "sRGB" : "Linear";
        if (channels == 4 && eight_bit) spec["oiio:UnassociatedAlpha"] = 1;
        if (!eight_bit)
            spec["DateTime"] = "1970:01:01 00:00:00"; // OpenEXR has the time otherwise: other bits each time
        if (*compression) spec["Compression"] = compression;
        if (!output->open("photo", spec) || !output->write_image(OIIO::TypeDesc::FLOAT, pixels) || !output->close())
            throw failure{VW_ERROR_IO, or_else(output->geterror(), "encoding failed")};
        result.size_bytes = memory.buffer().size();
        result.data = allocate(result.size_bytes);
        std::memcpy(result.data, memory.buffer().data(), result.size_bytes);
    });
}
