// Tables for people and other programs: CSV (RFC 4180, but lines end with LF), reals so that they
// read back to the same double. Each is made in memory; the path is for messages. A write function writes the same as a
// file, whole or not at all.
#ifndef VIEWWORTH_REPORT_TABLES_H
#define VIEWWORTH_REPORT_TABLES_H

#include <stdint.h>
#include <stdio.h>

#include "base/rows.h"
#include "value/matrix.h"
#include "value/payout.h"
#include "value/providers.h"
#include "value/worth.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

// Makes scores.csv: name,provider,method,value,unit,stderr,visits,rank,ci_low,ci_high,rank_ci_low,rank_ci_high; a row
// per train image and method, methods in the given order, best first; rank 1 = most valuable, ties by name.
enum vw_status vw_report_make_csv(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count, struct vw_csv_text *made);
// Prints its header with the line end, or the rows of one of several runs, each with `before` at its start.
void vw_report_print_csv_header(FILE *stream);
enum vw_status vw_report_print_csv_rows(FILE *stream, const char *path, const char *before,
                                        const struct vw_ledger_score *scores, uint32_t score_count,
                                        const struct vw_ledger_image *images, uint32_t image_count);

// Returns the rows of providers.csv: provider,method,value,unit,stderr,photos,rank; a row per method and provider as
// they come.
struct vw_rows vw_provider_rows(const struct vw_provider_score *groups, uint32_t count);
// Returns the rows of duplicates.csv: group,name,split,provider,similarity,method,value,unit,stderr,group_value; a row
// per photo, groups from 0.
struct vw_rows vw_duplicate_rows(const struct vw_duplicate_score *duplicates, uint32_t count);
// Returns how well left-out retrainings are predicted: spearman,ci_low,ci_high,r2,retrainings,method.
struct vw_rows vw_claim_rows(const struct vw_worth_summary *summary);
// Returns the rows of payout.csv: provider,value,photos,share,amount,ci_low,ci_high,unvalued; a row per provider, best
// paid first. value: sum of the photos' positive worths; unvalued: photos that have none. And those of
// payout_photos.csv: name,provider,value,share,amount,ci_low,ci_high; a row per photo that has a worth. Amounts have
// two decimals; those of a provider's photos add up to its own, and all to the whole.
struct vw_rows vw_payout_rows(const struct vw_payouts *payouts);
struct vw_rows vw_photo_payout_rows(const struct vw_payouts *payouts);
// Makes the text of matrix.csv; `path` is for messages. Its columns are
// name,provider,measure,unit,mean,jackknife_stderr, and one per validation view, by its name; per photo a row of
// dv_psnr, one of lasting_psnr where there is a backward pass by validation photo, and one of dv_loss. The last has
// neither mean nor jackknife_stderr: dv_loss is the mean weighted by the views' pixels, which the matrix does not
// contain (scores.csv has it). VW_ERROR_INPUT when the images lack one of the matrix.
enum vw_status vw_table_make_matrix(const char *path, const struct vw_matrix *matrix, const double *standard_errors,
                                    const struct vw_ledger_image *images, uint32_t image_count,
                                    struct vw_csv_text *made);

#endif
