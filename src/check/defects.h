// The limits of the evidence on photos. Internal to src/check.
#ifndef VIEWWORTH_CHECK_DEFECTS_H
#define VIEWWORTH_CHECK_DEFECTS_H

#include "check/evidence.h"
#include "viewworth/status.h"

// Lists the defects that the evidence shows. VW_ERROR_MEMORY.
enum vw_status vw_check_find_defects(struct vw_check *check);

#endif
