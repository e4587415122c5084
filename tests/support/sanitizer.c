// Every program of a build with the address sanitizer has this file, so that all of them search for leaks in one way:
// the leaks named here are those of other libraries, any other fails the program.

int dlclose(void *module);
const char *__asan_default_options(void);
const char *__lsan_default_suppressions(void);
const char *__lsan_default_options(void);

// Modules stay loaded: the search knows whose memory it finds by the code that allocated it, and that code has no name
// once the driver is unloaded.
int dlclose(void *module) {
    (void)module;
    return 0;
}

// Keeps what was freed for 16 MiB instead of 256: lavapipe allocates something for every workgroup, and each was a new
// page, which made a profile of passes take 35 s instead of 6.
const char *__asan_default_options(void) { return "quarantine_size_mb=16"; }

// Names whole files, which are never ours; a function where a library leaks on one path only. The validation layer
// reports Vulkan objects that we forget, so that the driver's line does not hide those.
const char *__lsan_default_suppressions(void) {
    return "leak:/libvulkan_lvp.so$\n"
           "leak:/libVkLayer_khronos_validation.so$\n";
}

// Keeps stderr the same as in other builds.
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
