#include "base/cache_folder.h"

#include <stdlib.h>

#include "base/memory.h"

char *vw_cache_path(const char *name) {
    const char *base = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (base && *base == '/') return vw_format_text("%s/viewworth/%s", base, name);
    return home && *home == '/' ? vw_format_text("%s/.cache/viewworth/%s", home, name) : NULL;
}
