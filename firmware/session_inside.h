// Between the session's own files.
#ifndef LAMELLA_FIRMWARE_SESSION_INSIDE_H
#define LAMELLA_FIRMWARE_SESSION_INSIDE_H

#include "session.h"

// Lights off first; the burst ends unwhole, in FAULT. Returns true: something was done.
bool session_fail(struct session* session, enum lam_part part, const char* why);

// What the collector says failed, the disk or a camera.
bool session_fail_by_collector(struct session* session);

#endif
