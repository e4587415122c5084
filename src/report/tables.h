// Tables beside scores.csv, for people and other programs: CSV (RFC 4180, but lines end with LF), reals so that they
// read back to the same double. Each is made in memory; the path is for messages. A write function writes the same as a
// file, whole or not at all.
#ifndef VIEWWORTH_REPORT_TABLES_H
#define VIEWWORTH_REPORT_TABLES_H

#include <stdint.h>

#include "base/csv.h"
#include "value/duplicate_scores.h"
#include "value/matrix.h"
#include "value/payout.h"
#include "value/providers.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

// Makes providers.csv: provider,method,value,unit,stderr,photos,rank; a row per method and provider as they come, rank
// 1 = most valuable.
enum vw_status vw_table_make_providers(const char *path, const struct vw_provider_score *groups, uint32_t count,
                                       struct vw_csv_text *made);
// Makes payout.csv: provider,method,value,unit,photos,share,amount,ci_low,ci_high,overlaps,validating,tests,unscored;
// a row per provider, best paid first. value: sum of the photos' positive scores. The amounts, with two decimals, add
// up to the whole, the interval of 90 % also has two. overlaps: providers that are not told apart. The last three
// count photos that have no score. And payout_photos.csv: name,provider,method,value,unit,share,amount,ci_low,ci_high;
// a row per photo with a score; the amounts of a provider's photos add up to its own.
enum vw_status vw_table_make_payout(const char *path, const struct vw_payouts *payouts, struct vw_csv_text *made);
enum vw_status vw_table_make_payout_photos(const char *path, const struct vw_payouts *payouts,
                                           struct vw_csv_text *made);
// Makes duplicates.csv: group,name,split,provider,similarity,method,value,unit,stderr,group_value; a row per photo,
// groups from 0.
enum vw_status vw_table_make_duplicates(const char *path, const struct vw_duplicate_score *rows, uint32_t count,
                                        struct vw_csv_text *made);
// Writes matrix.csv: name,provider,measure,unit,mean,jackknife_stderr, and a column per validation view, by its name;
// per photo a row of dv_psnr, one of lasting_psnr where there is a backward pass by validation photo, and one of
// dv_loss. The last has neither mean nor jackknife_stderr: dv_loss is the mean weighted by the views' pixels, which the
// matrix does not contain (scores.csv has it). VW_ERROR_INPUT when the images lack one of the matrix.
enum vw_status vw_table_write_matrix(const char *path, const struct vw_matrix *matrix, const double *standard_errors,
                                     const struct vw_ledger_image *images, uint32_t image_count);
enum vw_status vw_table_make_matrix(const char *path, const struct vw_matrix *matrix, const double *standard_errors,
                                    const struct vw_ledger_image *images, uint32_t image_count,
                                    struct vw_csv_text *made);

// Cents as "12.34".
enum { VW_AMOUNT_BYTES = 24 };
void vw_amount_to_text(uint64_t cents, char text[VW_AMOUNT_BYTES]);
// Writes both ends in the same way, rounded; "" where they are unknown.
void vw_amount_range_to_text(struct vw_payout_interval interval, char low[VW_AMOUNT_BYTES], char high[VW_AMOUNT_BYTES]);

#endif
