// All of libviewworth. A program that needs less includes single headers.
#ifndef VIEWWORTH_VIEWWORTH_H
#define VIEWWORTH_VIEWWORTH_H

#include "viewworth/gpu.h"
#include "viewworth/ledger.h"
#include "viewworth/log.h"
#include "viewworth/report.h"
#include "viewworth/run.h"
#include "viewworth/scene.h"
#include "viewworth/selection.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/types.h"
#include "viewworth/value.h"
#include "viewworth/version.h"

#endif
