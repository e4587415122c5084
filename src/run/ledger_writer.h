// Writes the steps of a run into its ledger on a thread of its own, so that the device works on while the disk syncs.
//
// While one transaction is written, the steps that are added wait, and become the next one: up to 1,024 steps, or one
// submission of the device. The thread alone uses the ledger from vw_ledger_writer_add() until vw_ledger_writer_drain()
// returns.
#ifndef VIEWWORTH_RUN_LEDGER_WRITER_H
#define VIEWWORTH_RUN_LEDGER_WRITER_H

#include <stdint.h>

#include "value/series.h"
#include "viewworth/ledger.h"

enum { VW_LEDGER_WRITER_WAITING_MOST = 1024 }; // steps

struct vw_ledger_writer;

// Creates a writer. `ledger` and `validation_views` (see vw_ledger_append) are borrowed and outlive it. `recorded`
// counts the steps that the ledger contains. VW_ERROR_MEMORY also when no thread can be created.
enum vw_status vw_ledger_writer_create(struct vw_ledger *ledger, const uint32_t *validation_views,
                                       const struct vw_step_statistics *recorded, struct vw_ledger_writer **writer);
// Copies the next steps, which vw_ledger_append() then writes in one transaction; `statistics` count them, too. Waits
// while there is no room for them. Every call after a failure returns that failure and drops its steps.
enum vw_status vw_ledger_writer_add(struct vw_ledger_writer *writer, const struct vw_step_record *records,
                                    uint32_t count, const struct vw_step_statistics *statistics);
// Waits until all that was added is on disk, or writing has failed.
enum vw_status vw_ledger_writer_drain(struct vw_ledger_writer *writer);
// Returns the step that the next vw_ledger_writer_add() begins with.
uint64_t vw_ledger_writer_next_step(const struct vw_ledger_writer *writer);
// Returns the statistics of the steps that are on disk.
struct vw_step_statistics vw_ledger_writer_recorded(struct vw_ledger_writer *writer);
// Writes what waits first; a failure is not reported any more.
void vw_ledger_writer_destroy(struct vw_ledger_writer **writer);

#endif
