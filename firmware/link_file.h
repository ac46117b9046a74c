// Files of the state folder: small, private, whole or not there.
#ifndef LAMELLA_FIRMWARE_LINK_FILE_H
#define LAMELLA_FIRMWARE_LINK_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "status.h"

enum { LINK_FILE_PATH_CHARS = 320, LINK_FILE_MAX_BYTES = 16384 };

// "FOLDER/NAME". False where it is longer than a path may be.
bool link_file_path(const char* folder, const char* name, char path[LINK_FILE_PATH_CHARS]);

// Reads at most `room` - 1 bytes and ends them with a 0. LAM_WRONG_STATE where there is no such
// file, LAM_BAD_INPUT where it is larger, no plain file, or open to anybody but its owner.
enum lam_status link_file_read(const char* path, char* text, size_t room, size_t* size, char* error,
                               size_t error_size);

// Writes beside the place, mode 0600, and renames; on the disk when it returns.
enum lam_status link_file_write(const char* path, const char* text, size_t size, char* error,
                                size_t error_size);

#endif
