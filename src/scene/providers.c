// Providers of views: a CSV file with the header name,provider, and the names that they may have. Names that look the
// same must be the same, since money follows them.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <utf8proc.h>

#include "base/csv.h"
#include "base/memory.h"
#include "scene/builder.h"

// ---- One name -------------------------------------------------------------------------------------------------------

// Returns whether a character shows what it is: no control or format character, no space but the plain one, none that
// these Unicode tables do not know, no filler that is blank, and no symbol but those up to the letterlike ones (signs
// of copyright and trade mark), since some of the others are blank.
static bool is_visible(utf8proc_int32_t character) {
    enum { LETTERLIKE_LAST = 0x214f, KHITAN_FILLER = 0x16fe4, EGYPTIAN_BLANK = 0x13441, EGYPTIAN_HALF_BLANK };
    switch (utf8proc_category(character)) {
    case UTF8PROC_CATEGORY_CC:
    case UTF8PROC_CATEGORY_CF:
    case UTF8PROC_CATEGORY_CN:
    case UTF8PROC_CATEGORY_CO:
    case UTF8PROC_CATEGORY_CS:
    case UTF8PROC_CATEGORY_ZL:
    case UTF8PROC_CATEGORY_ZP: return false;
    case UTF8PROC_CATEGORY_ZS: return character == ' ';
    case UTF8PROC_CATEGORY_SO: return character <= LETTERLIKE_LAST;
    default:
        return character != KHITAN_FILLER && character != EGYPTIAN_BLANK && character != EGYPTIAN_HALF_BLANK &&
               !utf8proc_get_property(character)->ignorable;
    }
}

enum vw_status vw_provider_name_take(const char *text, char **name) {
    const char *begin = text + strspn(text, " \t"), *end = begin + strlen(begin);
    while (end > begin && (end[-1] == ' ' || end[-1] == '\t')) end--;
    for (const char *place = begin; place < end;) {
        utf8proc_int32_t character;
        utf8proc_ssize_t length = utf8proc_iterate((const utf8proc_uint8_t *)place, end - place, &character);
        if (length <= 0) return vw_fail(VW_ERROR_INPUT, "the provider's name is not UTF-8; save the file as UTF-8");
        if (!is_visible(character))
            return vw_fail(
                VW_ERROR_INPUT,
                "the provider's name has the character U+%04X, which cannot be seen, is a symbol or is another space "
                "than the plain one; type the name anew without it",
                (unsigned)character);
        place += length;
    }
    *name = vw_format_text("%.*s", (int)(end - begin), begin);
    return *name ? VW_OK : VW_ERROR_MEMORY;
}

// ---- Names that look alike ------------------------------------------------------------------------------------------

// A view's provider and its sort key: the name with case, width, composition, dashes and runs of spaces folded.
struct named {
    char *key; // owned
    const char *name;
    uint32_t line; // 0: of the scene
};

static void join_spaces(char *key) {
    char *to = key;
    for (const char *from = key; *from; from++)
        if (*from != ' ' || (to > key && to[-1] != ' ')) *to++ = *from;
    *to = 0;
}

static enum vw_status fold(const char *name, char **key) {
    utf8proc_uint8_t *folded = NULL;
    utf8proc_ssize_t length = utf8proc_map((const utf8proc_uint8_t *)name, 0, &folded,
                                           UTF8PROC_NULLTERM | UTF8PROC_STABLE | UTF8PROC_COMPOSE | UTF8PROC_COMPAT |
                                               UTF8PROC_CASEFOLD | UTF8PROC_IGNORE | UTF8PROC_LUMP);
    if (length < 0) return vw_fail(VW_ERROR_MEMORY, "out of memory for the name of a provider");
    *key = (char *)folded;
    join_spaces(*key);
    return VW_OK;
}

// Sorts by the key, then by the line.
static int compare_named(const void *left, const void *right) {
    const struct named *a = left, *b = right;
    int order = strcmp(a->key, b->key);
    return order ? order : (a->line > b->line) - (a->line < b->line);
}

static enum vw_status refuse_alike(const char *path, const struct named *first, const struct named *second) {
    char place[32] = "the scene";
    if (first->line) snprintf(place, sizeof place, "line %u", first->line);
    enum vw_status status = vw_fail(
        VW_ERROR_INPUT, "provider \"%s\" looks like \"%s\" of %s; write one provider in one way, letter by letter",
        second->name, first->name, place);
    return second->line ? vw_fail_context(status, "%s:%u", path, second->line) : vw_fail_context(status, "%s", path);
}

static enum vw_status find_alike(const char *path, struct named *named, uint32_t count) {
    uint32_t first = 0; // the first with this key
    qsort(named, count, sizeof *named, compare_named);
    for (uint32_t i = 1; i < count; i++) {
        if (strcmp(named[i].key, named[first].key) != 0) first = i;
        else if (strcmp(named[i].name, named[first].name) != 0) return refuse_alike(path, &named[first], &named[i]);
    }
    return VW_OK;
}

// Refuses providers that only case or what cannot be seen tells apart. `lines` are those of the views, 0: of the scene.
static enum vw_status check_alike(const char *path, const struct vw_scene *scene, const uint32_t *lines) {
    struct named *named = vw_allocate(scene->view_count, sizeof *named);
    uint32_t count = 0;
    enum vw_status status = named ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t v = 0; !status && v < scene->view_count; v++) {
        const char *name = scene->views[v].provider;
        if (!*name) continue;
        named[count] = (struct named){.name = name, .line = lines[v]};
        status = fold(name, &named[count].key);
        count += !status;
    }
    if (!status) status = find_alike(path, named, count);
    for (uint32_t i = 0; i < count; i++) free(named[i].key);
    free(named);
    return status;
}

// ---- The file -------------------------------------------------------------------------------------------------------

struct reading {
    const struct vw_scene *scene;
    uint32_t *lines; // line of each view's provider
};

static enum vw_status take_provider(void *context, const struct vw_csv *csv, struct vw_view *view) {
    const struct reading *reading = context;
    char *provider = NULL;
    enum vw_status status = vw_provider_name_take(csv->fields[1], &provider);
    if (status) return vw_fail_context(status, "%s:%u", csv->path, csv->line);
    free(view->provider);
    view->provider = provider;
    reading->lines[view - reading->scene->views] = csv->line;
    return VW_OK;
}

enum vw_status vw_providers_read(const char *path, struct vw_scene *scene) {
    uint32_t *lines = vw_allocate(scene->view_count, sizeof *lines);
    if (!lines) return VW_ERROR_MEMORY;
    struct reading reading = {scene, lines};
    enum vw_status status = path ? vw_scene_table_read(scene, path, "provider", take_provider, &reading) : VW_OK;
    if (!status) status = check_alike(path ? path : scene->path, scene, lines);
    free(lines);
    return status;
}
