// The version of the library, and how its headers declare what it exports.
#ifndef VIEWWORTH_VERSION_H
#define VIEWWORTH_VERSION_H

// Brackets of the declarations in every public header: C linkage, and visible outside the shared library, which hides
// everything else.
#ifdef __cplusplus
#define VW_PUBLIC_BEGIN                                                                                                \
    extern "C" {                                                                                                       \
    _Pragma("GCC visibility push(default)")
#define VW_PUBLIC_END                                                                                                  \
    _Pragma("GCC visibility pop")                                                                                      \
    }
#else
#define VW_PUBLIC_BEGIN _Pragma("GCC visibility push(default)")
#define VW_PUBLIC_END _Pragma("GCC visibility pop")
#endif

VW_PUBLIC_BEGIN

const char *vw_version(void); // "0.1.0"; static

VW_PUBLIC_END

#endif
