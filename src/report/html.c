#include <jansson.h>
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/text_stream.h"
#include "report/html_data.h"
#include "report/html_parts.h"
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

// Writes a policy that loads nothing and runs only the scripts of the program.
static void write_policy(FILE *stream) {
    fputs("default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; style-src", stream);
    write_hash(stream, vw_html_style);
    fputs("; script-src", stream);
    write_hash(stream, vw_html_chart);
    write_hash(stream, vw_html_widgets);
    write_hash(stream, vw_html_script);
    write_hash(stream, vw_html_tradeoff);
    write_hash(stream, vw_html_benchmark);
    write_hash(stream, vw_html_photos);
    write_hash(stream, vw_html_scores);
    write_hash(stream, vw_html_tables);
}

static bool write_piece(FILE *stream, const char *name, const json_t *data) {
    if (strcmp(name, "policy") == 0) write_policy(stream);
    else if (strcmp(name, "style") == 0) fputs(vw_html_style, stream);
    else if (strcmp(name, "chart") == 0) fputs(vw_html_chart, stream);
    else if (strcmp(name, "widgets") == 0) fputs(vw_html_widgets, stream);
    else if (strcmp(name, "script") == 0) fputs(vw_html_script, stream);
    else if (strcmp(name, "tradeoff") == 0) fputs(vw_html_tradeoff, stream);
    else if (strcmp(name, "benchmark") == 0) fputs(vw_html_benchmark, stream);
    else if (strcmp(name, "photos") == 0) fputs(vw_html_photos, stream);
    else if (strcmp(name, "scores") == 0) fputs(vw_html_scores, stream);
    else if (strcmp(name, "tables") == 0) fputs(vw_html_tables, stream);
    else if (strcmp(name, "data") == 0)
        return json_dump_callback(data, write_escaped, stream,
                                  JSON_COMPACT | JSON_ENSURE_ASCII | JSON_REAL_PRECISION(REAL_DIGITS)) == 0;
    return true;
}

// ---- The page ----

static bool write_page(FILE *stream, const json_t *data) {
    bool complete = true;
    for (const char *rest = vw_html_template; rest && complete;) {
        const char *mark = strstr(rest, "{{");
        fwrite(rest, 1, mark ? (size_t)(mark - rest) : strlen(rest), stream);
        char name[16] = "";
        if (mark) sscanf(mark, "{{%15[a-z]}}", name);
        if (mark) complete = write_piece(stream, name, data);
        rest = mark ? mark + strlen("{{}}") + strlen(name) : NULL;
    }
    return complete;
}

enum vw_status vw_report_write_html(const char *path, const struct vw_report_page *page) {
    json_t *data = NULL;
    char *text = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_html_data_make(page, &data);
    if (status) return status;
    struct vw_text_stream html;
    bool complete = vw_text_stream_open(&html) && write_page(html.stream, data);
    status = vw_text_stream_close(&html, path, &text, &size_bytes);
    if (!status && !complete) status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory for the page", path);
    if (!status) status = vw_file_write(path, text, size_bytes);
    json_decref(data);
    free(text);
    return status;
}
