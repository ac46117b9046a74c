// A file that the operator named, read whole. A pipe or a device in its place is refused: the
// daemon would wait for whoever writes into it.
#ifndef LAMELLA_FIRMWARE_INPUT_FILE_H
#define LAMELLA_FIRMWARE_INPUT_FILE_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>

enum { INPUT_FILE_WHY_CHARS = 96 };

// False, with the reason, where it is longer than `room` or cannot be read; errno is ENOENT then
// where there is no such file.
bool input_file_read(const char* path, void* bytes, size_t room, size_t* size,
                     char why[INPUT_FILE_WHY_CHARS]);

// Where `path` leads, be it a link or not; false, with errno, for a link to nothing.
bool input_file_place(const char* path, char place[PATH_MAX]);

#endif
