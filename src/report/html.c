#include <jansson.h>
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "report/page.h"

enum { REAL_DIGITS = 8 }; // more than a page shows

// ---- The pieces ----

// Escapes three characters: jansson escapes its own and leaves other ASCII alone, so that nothing else could end or
// begin anything in HTML.
static int write_escaped(const char *text, size_t size_bytes, void *stream) {
    for (size_t i = 0; i < size_bytes; i++) {
        bool marked = text[i] == '<' || text[i] == '>' || text[i] == '&';
        if (marked ? fprintf(stream, "\\u%04x", (unsigned)text[i]) < 0 : fputc(text[i], stream) == EOF) return -1;
    }
    return 0;
}

static void write_hash(FILE *stream, const char *text) {
    uint8_t hash[VW_HASH_BYTES];
    char base64[sodium_base64_ENCODED_LEN(sizeof hash, sodium_base64_VARIANT_ORIGINAL)];
    vw_sha256(text, strlen(text), hash);
    sodium_bin2base64(base64, sizeof base64, hash, sizeof hash, sodium_base64_VARIANT_ORIGINAL);
    fprintf(stream, " 'sha256-%s'", base64);
}

static const struct {
    const char *name, *text;
} scripts[] = {{"chart", vw_html_chart},       {"widgets", vw_html_widgets}, {"script", vw_html_script},
               {"tradeoff", vw_html_tradeoff}, {"photos", vw_html_photos},   {"scores", vw_html_scores},
               {"tables", vw_html_tables}};

// Writes a policy that loads nothing and runs only the scripts of the program.
static void write_policy(FILE *stream, const char *extra) {
    fputs("default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; style-src", stream);
    write_hash(stream, vw_html_style);
    fputs("; script-src", stream);
    for (size_t i = 0; i < VW_ARRAY_COUNT(scripts); i++) write_hash(stream, scripts[i].text);
    write_hash(stream, extra);
}

static bool write_piece(FILE *stream, const char *name, const char *extra, const json_t *data) {
    if (strcmp(name, "policy") == 0) write_policy(stream, extra);
    if (strcmp(name, "style") == 0) fputs(vw_html_style, stream);
    if (strcmp(name, "extra") == 0) fputs(extra, stream);
    for (size_t i = 0; i < VW_ARRAY_COUNT(scripts); i++)
        if (strcmp(name, scripts[i].name) == 0) fputs(scripts[i].text, stream);
    return strcmp(name, "data") != 0 ||
           json_dump_callback(data, write_escaped, stream,
                              JSON_COMPACT | JSON_ENSURE_ASCII | JSON_REAL_PRECISION(REAL_DIGITS)) == 0;
}

// ---- The page ----

static bool write_page(FILE *stream, const char *extra, const json_t *data) {
    bool complete = true;
    for (const char *rest = vw_html_template; rest && complete;) {
        const char *mark = strstr(rest, "{{");
        fwrite(rest, 1, mark ? (size_t)(mark - rest) : strlen(rest), stream);
        char name[16] = "";
        if (mark) sscanf(mark, "{{%15[a-z]}}", name);
        if (mark) complete = write_piece(stream, name, extra, data);
        rest = mark ? mark + strlen("{{}}") + strlen(name) : NULL;
    }
    return complete;
}

// Returns the scripts that only some pages have, owned by the caller; NULL: memory is short.
static char *join_extra(const struct vw_report_page *page) {
    bool plans = false;
    for (uint32_t i = 0; i < page->run_count; i++) plans |= page->runs[i]->next != NULL;
    return vw_format_text("%s%s", page->extra ? page->extra->script : "", plans ? vw_html_next : "");
}

enum vw_status vw_report_write_html(const char *path, const struct vw_report_page *page) {
    json_t *data = NULL;
    char *text = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_html_data_make(page, &data);
    if (status) return status;
    struct vw_text_stream html;
    char *extra = join_extra(page);
    bool complete = vw_text_stream_open(&html) && extra && write_page(html.stream, extra, data);
    status = vw_text_stream_close(&html, path, &text, &size_bytes);
    if (!status && !complete) status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory for the page", path);
    if (!status) status = vw_file_write(path, text, size_bytes);
    json_decref(data);
    free(extra);
    free(text);
    return status;
}
