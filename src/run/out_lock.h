// One writer per folder of results. Whoever writes into an OUT holds its lock from before the first write until the
// end; readers take none.
#ifndef VIEWWORTH_RUN_OUT_LOCK_H
#define VIEWWORTH_RUN_OUT_LOCK_H

#include <stdint.h>

#include "run/out_files.h"
#include "viewworth/status.h"

struct vw_out_lock;

// Creates OUT if it is not there, locks it, and removes what a killed writer has left half-written. VW_ERROR_USAGE, at
// once, when a link lies below OUT, a folder has the name of a result, or another process or another run of this one
// writes there. The lock is one of the kernel's on OUT/.viewworth.lock, so that it ends with the process, however that
// ends; on a file system without locks there is a warning instead.
enum vw_status vw_out_lock_take(const char *out, struct vw_out_lock **lock);
// Locks the one of the folders that the file `to` lies in, if it lies in one of them. `*lock` is NULL otherwise.
enum vw_status vw_out_lock_take_for(const char *to, const char *const *folders, uint32_t folder_count,
                                    struct vw_out_lock **lock);
// Returns the folder that is locked, as it was named.
const char *vw_out_lock_folder(const struct vw_out_lock *lock);
// Leaves the lock file. Removes OUT if the lock created it and nothing else was written to it.
void vw_out_lock_release(struct vw_out_lock **lock);

#endif
