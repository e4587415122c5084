// Fuzz targets: one per kind of file. Each takes any bytes as such a file. It may refuse them, but only in one line; a
// scene that it takes must be fit to train on. Anything else aborts. scripts/fuzz drives them with libFuzzer,
// test_fuzz_corpus.c with the inputs that are kept.
#ifndef VIEWWORTH_TESTS_FUZZ_FUZZ_H
#define VIEWWORTH_TESTS_FUZZ_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "train/files/training_files.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

typedef void fuzz_target(const uint8_t *data, size_t size_bytes);

fuzz_target fuzz_transforms;    // transforms.json
fuzz_target fuzz_colmap_binary; // cameras.bin, images.bin and points3D.bin (see fuzz_write_model)
fuzz_target fuzz_colmap_text;   // cameras.txt, images.txt and points3D.txt, likewise
fuzz_target fuzz_tsv;           // the split file of NeRF-W
fuzz_target fuzz_recipe;        // a recipe; nothing is drawn
fuzz_target fuzz_ledger;        // edits of a valid ledger.db and of a journal beside it (database_edits.h)
fuzz_target fuzz_store;         // likewise, of retrainings.db
fuzz_target fuzz_checkpoint;    // checkpoint_0.vwc (see fuzz_write_hashed)
fuzz_target fuzz_field;         // field.vwf, likewise
fuzz_target fuzz_splats;        // the .ply file of --initial
fuzz_target fuzz_features;      // the .npy file of a photo's features
fuzz_target fuzz_steps;         // the log of import-steps
fuzz_target fuzz_providers;     // --providers
// Lists of photos: scores after an s, JSON after a j, splits.json after a p, otherwise names or a TSV after any byte.
fuzz_target fuzz_lists;
fuzz_target fuzz_tables;  // CSV files that a report shows; a byte before them says which one
fuzz_target fuzz_compare; // compare.json
fuzz_target fuzz_jobs;    // JOBS.json of submission
// A photo of any format, as a worker of viewworth-decode reads it. What this finds in OpenImageIO itself ends a worker.
// It needs viewworth_decode_core.
fuzz_target fuzz_photo;

// Returns the folder that targets work in, made at the first call and removed at the process's end: the photos 00.png
// to 07.png, of 8 x 6 pixels, are in images/. It must be removed before another target runs, which would find the files
// of the one before.
const char *fuzz_folder(void);
void fuzz_remove_folder(void);
// Writes folder/name and returns its path as temporary_path() does.
const char *fuzz_write(const char *name, const uint8_t *data, size_t size_bytes);
// Writes the three files of a COLMAP model into folder/model_folder. Their bytes follow one another, after the sizes of
// the first two, each as two bytes with the lower one first.
void fuzz_write_model(const char *model_folder, const char *extension, const uint8_t *data, size_t size_bytes);
// Opens a scene without reading pixels, and checks what it says or gives.
void fuzz_open(const char *path, const char *format);
// Writes a file that ends with its hash. After an h, the hash of the other bytes is added to them, so that the code
// after the check of the hash is reached as well; after any other byte, the rest is the file.
const char *fuzz_write_hashed(const char *name, const uint8_t *data, size_t size_bytes);
void fuzz_check_hashed(const struct vw_hashed_file *file, uint64_t payload_bytes);
// Returns a scene of the eight photos, for the files that name photos; kept, as the folder is.
struct vw_scene *fuzz_scene(void);
// Reads a file of that name as a report does.
void fuzz_check_report(const char *name, const uint8_t *data, size_t size_bytes);
// Aborts, and says what is not so.
void fuzz_check(bool condition, const char *what);
// Forgets the message before a function that may fail; fuzz_check_message(), called with its status after it, aborts
// unless a failure left a message of one line.
void fuzz_forget_message(void);
void fuzz_check_message(enum vw_status status);

#endif
