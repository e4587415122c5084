#include "base/utc.h"

#include <time.h>

void vw_utc_now(char text[VW_UTC_BYTES]) {
    time_t now = time(NULL);
    struct tm parts;
    gmtime_r(&now, &parts);
    strftime(text, VW_UTC_BYTES, "%Y-%m-%dT%H:%M:%SZ", &parts);
}
