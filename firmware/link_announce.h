// How the rig is found: an Avahi service file (mDNS, _lamella._tcp), written before the daemon
// starts. The daemon itself speaks no mDNS. What it says helps to find a rig; nothing is trusted
// for it.
#ifndef LAMELLA_FIRMWARE_LINK_ANNOUNCE_H
#define LAMELLA_FIRMWARE_LINK_ANNOUNCE_H

#include "link_door.h"

// LAM_BAD_INPUT for a place that is not announced: no address, no port, no state folder.
enum lam_status announce_write(const char* path, const struct link_place* place, char* error,
                               size_t error_size);

#endif
