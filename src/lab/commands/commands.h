// The commands of viewworth-lab that are its own, or need its options.
#ifndef VIEWWORTH_LAB_COMMANDS_COMMANDS_H
#define VIEWWORTH_LAB_COMMANDS_COMMANDS_H

#include "lab/options.h"

enum vw_status vw_lab_benchmark(const struct vw_options *options);
enum vw_status vw_lab_copies(const struct vw_options *options);
enum vw_status vw_lab_probe(const struct vw_options *options);
enum vw_status vw_lab_report(const struct vw_options *options);
enum vw_status vw_lab_reproduce(const struct vw_options *options);
enum vw_status vw_lab_tradeoff(const struct vw_options *options);

extern const char vw_lab_page_script[]; // output/benchmark_page.js: the section of the report on benchmark.csv

#endif
