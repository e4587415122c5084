// Fuzz targets: one per kind of scene file. Each takes any bytes as such a file. It may refuse them, but only in one
// line; what it takes must be fit to train on. Anything else aborts. scripts/fuzz drives them with libFuzzer,
// test_fuzz_corpus.c with the inputs that are kept.
#ifndef TESTS_FUZZ_FUZZ_H
#define TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

typedef void fuzz_target(const uint8_t *data, size_t size_bytes);

fuzz_target fuzz_transforms;    // transforms.json
fuzz_target fuzz_colmap_binary; // cameras.bin, images.bin and points3D.bin (see fuzz_write_model)
fuzz_target fuzz_colmap_text;   // cameras.txt, images.txt and points3D.txt, likewise
fuzz_target fuzz_tsv;           // the split file of NeRF-W
fuzz_target fuzz_recipe;        // a recipe; nothing is drawn
fuzz_target fuzz_ledger;        // edits of a valid ledger.db and of a journal beside it (database_edits.h)
fuzz_target fuzz_store;         // likewise, of retrainings.db or tradeoff.db, as the first byte says

// The folder that targets work in, made at the first call and removed at the process's end: the photos 00.png to
// 07.png, of 8 x 6 pixels, are in images/. It must be removed before another target runs, which would find the files of
// the one before.
const char *fuzz_folder(void);
void fuzz_remove_folder(void);
// Writes folder/name and returns its path as temporary_path() does.
const char *fuzz_write(const char *name, const uint8_t *data, size_t size_bytes);
// Writes the three files of a COLMAP model into folder/model_folder. Their bytes follow one another, behind the sizes
// of the first two, each as two bytes with the lower one first.
void fuzz_write_model(const char *model_folder, const char *extension, const uint8_t *data, size_t size_bytes);
// Opens a scene without reading pixels, and checks what it says or gives.
void fuzz_open(const char *path, const char *format);
// To be called before a function that may fail, and with its status after it: aborts unless a failure left a message of
// one line.
void fuzz_forget_message(void);
void fuzz_check_message(enum vw_status status);

#endif
