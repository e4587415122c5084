// The version of the library.
#ifndef VIEWWORTH_VERSION_H
#define VIEWWORTH_VERSION_H

const char *vw_version(void); // "0.1.0"; static

#endif
