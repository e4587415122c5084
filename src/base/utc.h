// The current time, for the ledger's columns only.
#ifndef VIEWWORTH_BASE_UTC_H
#define VIEWWORTH_BASE_UTC_H

enum { VW_UTC_BYTES = 21 }; // "2026-11-21T03:04:05Z"

void vw_utc_now(char text[VW_UTC_BYTES]);

#endif
