// The simulated rig's line to the digital twin: a report out, a photograph back (PROTOCOL.md).
#ifndef LAMELLA_FIRMWARE_HAL_SIM_TWIN_H
#define LAMELLA_FIRMWARE_HAL_SIM_TWIN_H

#include <stdbool.h>

#include "hal.h"

// Connects to the local socket at `path`; -1, and a reason in `error`, where it cannot.
int sim_twin_connect(const char* path, char* error, size_t error_size);

// Sends the report and receives the photograph it asks for, checksum checked. False with a reason
// in photograph->error.
bool sim_twin_photograph(int socket, const lamella_v1_ExposureReport* report,
                         struct hal_photograph* photograph);

void sim_twin_disconnect(int socket);

#endif
